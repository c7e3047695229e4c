"""Cut a scan to its straight piece on a target plane; points on other things, and at the plane's edges, are left out."""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

LEAST_POINTS = 20
LEAST_LENGTH = 0.02  # m: a shorter piece determines a plane's tilt badly
TRIALS = 60  # pairs of points that are tried as lines: enough where a quarter of the points are on the piece (1 - (1 - 1/16)^60 = 0.98)
_GAP = 5  # times the median distance between neighbouring points: a wider gap ends a piece


def straight_piece(points: Array, tolerance: float, rng: np.random.Generator) -> Array:
    """Return which points of a scan are its longest straight piece, ``(M,)`` bool; all False if it has none.

    Lines through two points are tried (Fischler and Bolles, 1981), and the one with the most points within the tolerance is fitted again to
    them by least squares.

    Args:
        points: ``(M, 2)`` [m], in the order of the scan.
        tolerance: How far a point may be from the line [m].
        rng: Draws the pairs.
    """
    M = len(points)
    none = np.zeros(M, dtype=bool)
    if M < LEAST_POINTS:
        return none
    best = none
    for _ in range(TRIALS):
        i, j = rng.choice(M, 2, replace=False)
        on = _near(points, points[i], points[j] - points[i], tolerance)
        if on.sum() > best.sum():
            best = on
    for _ in range(2):
        if best.sum() < LEAST_POINTS:
            return none
        centre = points[best].mean(axis=0)
        direction = np.linalg.svd(points[best] - centre, full_matrices=False)[2][0]
        best = _near(points, centre, direction, tolerance)
    run = _longest_run(points, best)
    if run.sum() < LEAST_POINTS or np.linalg.norm(np.ptp(points[run], axis=0)) < LEAST_LENGTH:
        return none
    return run


def _near(points: Array, start: Array, direction: Array, tolerance: float) -> Array:
    """Return which points lie within the tolerance [m] of the line through ``start`` along ``direction``, ``(M,)`` bool."""
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return np.zeros(len(points), dtype=bool)
    x, z = (points - start).T
    return np.abs(x * direction[1] - z * direction[0]) <= tolerance * length


def _longest_run(points: Array, on: Array) -> Array:
    """Return which points are in the longest run without a wide gap of the points ``on`` a line, ``(M,)`` bool."""
    index = np.flatnonzero(on)
    steps = np.linalg.norm(np.diff(points[index], axis=0), axis=1)
    wide = np.flatnonzero(steps > max(_GAP * float(np.median(steps)), 1e-3))
    parts = np.split(index, wide + 1)
    run = np.zeros(len(points), dtype=bool)
    run[max(parts, key=len)] = True
    return run
