"""Explain the published curves: which effect that the original paper does not mention made its curves go flat?

The published curves are treated as measured data, one run for each point. Each candidate explanation predicts, for every published point, how the
logarithms of the four errors (mean and maximum, position and orientation) scatter over seeds. The candidates are then compared by their evidence,
with their magnitudes fitted to the curves. ``recovery`` injects each candidate and shows which of them this method distinguishes.
"""
