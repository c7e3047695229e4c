"""Explain the published curves: which undeclared effect made the published curves go flat?

The curves are measured data, one run for each point. Each candidate effect predicts, for every published point, how the
logarithms of the four errors (mean and maximum, position and orientation) scatter over seeds; the curves then weigh
the candidates, their sizes fitted. ``recovery`` injects each candidate and shows what this method can distinguish.
"""
