"""The experiments of the paper: simulate over many seeds, calibrate or diagnose, evaluate, summarise.

A study is a grid of cases, each a scene with some of its keys replaced, and each case is repeated over seeds.
A step is a function that writes a folder or returns tables; the workflow spreads the steps over jobs, and
nothing here knows of it. Importing this package imports nothing else, so that a step needs only what it uses.
"""
