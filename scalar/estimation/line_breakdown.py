"""Scans whose line has broken down: so many of their points are stray that no line found among them can be trusted.

The line of least absolute deviations withstands between 29 % of stray points (all at one end of the scan, all to one side) and nearly one
half (anywhere, to either side). Beyond that it follows the stray points, and the limit beyond which a point is stray grows with them: hardly a
point is set aside, and nothing looks wrong. The points that are kept show the breakdown. Without stray points among them, the third of them that
lies closest to a common line scatters about it as all points do about theirs. With stray points among them, that third scatters far less. The
least median of squares (Rousseeuw, 1984) compares half of the points; a third is enough here, since stray points are scattered.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from scalar.data.dataset import Dataset
from scalar.estimation.settings import DEFAULTS, GrossErrorSettings
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

_PART = 1.0 / 3.0  # share of a scan's points that is compared with all of them
_LEAST_PART = 11  # points: fewer lie near some line by chance
_LINES = 150  # lines through pairs of points that are tried: with two points in three stray, about sixteen pairs hold no stray point
_POINTS = 60  # points of a scan with which the lines are compared; with more, the result is the same
_SCANS = 100  # scans that are judged: a share of one half is then known with a standard error of a twentieth
_ROUNDS = 10  # of refining the line; later ones change nothing
_CORE = 2.5  # standard deviations: points nearer to the line than this are its core, which contains at least the densest third
_CORE_TO_STD = 1.048  # ratio of a normal law's standard deviation to that of the same law cut off at the core


def share_of_broken_lines(
    dataset: Dataset, corrupted: Array, settings: GrossErrorSettings = DEFAULTS.gross_errors
) -> float:
    """Return the share of scans that are corrupted or whose line has broken down; zero for sensors without scans.

    In a dataset with many scans, the share is that among ``_SCANS`` of them, drawn with a fixed seed.

    Args:
        dataset: Without the points that were found off their scan's line.
        corrupted: ``(N,)`` bool, scans of which too many points were found off the line.
        settings: Thresholds.
    """
    if not kind_of(dataset).scans:
        return 0.0
    rng = np.random.default_rng(0)
    judged = rng.permutation(dataset.n_poses)[:_SCANS]
    starts = dataset.starts
    broken = [
        bool(corrupted[i]) or line_has_broken_down(dataset.points[starts[i] : starts[i + 1]], settings)
        for i in judged
    ]
    return float(np.mean(broken))


def line_has_broken_down(points: Array, settings: GrossErrorSettings = DEFAULTS.gross_errors) -> bool:
    """Return whether the points of a scan scatter about their line far more than the densest third of them about some line.

    Args:
        points: ``(M, 2)`` [m], those that were kept; fewer than twelve never count as broken down.
        settings: Thresholds.
    """
    least_std = settings.least_point_error / settings.point_sigmas  # a smaller scatter [m] counts as this one
    if len(points) <= _LEAST_PART:
        return False
    scatter = _line(points)[2]
    if scatter <= settings.line_breakdown * least_std:
        return False
    return scatter > settings.line_breakdown * max(_core_scatter(points), least_std)


def _line(points: Array) -> tuple[Array, float, float]:
    """Return normal ``(2,)``, distance [m] and standard deviation [m] of the line of total least squares of points ``(M, 2)`` [m]."""
    mean = points.mean(axis=0)
    off = points - mean
    squares, axes = np.linalg.eigh(off.T @ off)
    normal = axes[:, 0]
    return normal, float(normal @ mean), float(np.sqrt(max(squares[0], 0.0) / (len(points) - 2)))


def _core_scatter(points: Array) -> float:
    """Return the standard deviation [m] that a normal law would have if its densest third lay as close to a line as that of these points.

    Lines through random pairs of points are tried, and the one with the nearest third of the points is refined by fits to its core. The third is
    at least ``_LEAST_PART`` points; if there are no more points than that, infinity is returned.

    Args:
        points: ``(M, 2)`` [m].
    """
    every = int(np.ceil(len(points) / _POINTS))
    some = points[::every]
    M = len(some)
    part = max(int(np.ceil(_PART * M)), _LEAST_PART)
    if part >= M:
        return np.inf
    rng = np.random.default_rng(0)
    first = rng.integers(0, M, _LINES)
    along = some[(first + rng.integers(1, M, _LINES)) % M] - some[first]
    length = np.hypot(along[:, 0], along[:, 1])
    apart = length > 0  # pairs of two different points
    normals = np.stack([-along[apart, 1], along[apart, 0]], axis=1) / length[apart, None]
    distances = np.sum(normals * some[first[apart]], axis=1)
    off_lines = np.abs(normals @ some.T - distances[:, None])
    farthest_of_part = np.partition(off_lines, part - 1, axis=1)[:, part - 1]
    best = int(np.argmin(farthest_of_part))
    normal, distance = normals[best], float(distances[best])
    std = float(farthest_of_part[best] / ndtri(0.5 + 0.5 * part / M))
    least = max(int(np.ceil(_PART * len(points))), _LEAST_PART)
    for _ in range(_ROUNDS):
        off = np.abs(points @ normal - distance)
        core = points[off <= max(_CORE * std, float(np.partition(off, least - 1)[least - 1]))]
        normal, distance, cut_off = _line(core)
        before, std = std, _CORE_TO_STD * cut_off
        if abs(std - before) <= 1e-3 * std:
            break
    return std
