"""The closed loop: cells with something planted in them, diagnosed blind, and scored against what was planted.

The simulator plants by its own physics (``scalar.simulation``); the diagnosis sees a ``Dataset`` and nothing else.
"""
