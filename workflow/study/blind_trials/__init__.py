"""The blind trials: workcells with something injected in them, diagnosed blind, and scored against what was injected.

The simulator injects by its own physics (``scalar.simulation``); the diagnosis sees a ``Dataset`` and nothing else.
"""
