"""Errors of a real line scanner, from physics or from a model of how it measures: one file for each origin.

None of them is an effect of the arm. Each is off by default; with all of them off, a scene is the same to the byte.
"""
