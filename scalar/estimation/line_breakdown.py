"""Scans whose line has broken down: so many of their points are stray that no line found among them can be trusted.

The line of least absolute deviations withstands between 29 % of stray points (all at one end of the scan, all to one side) and nearly one
half (anywhere, to either side). Beyond that it follows the stray points, and the limit beyond which a point is stray grows with them: hardly a
point is set aside, and nothing looks wrong. The points that are kept show the breakdown. Without stray points among them, their densest part
scatters about some line as all of them do about theirs. With stray points among them, it scatters far less. That part need not be more than
half of the points, as for the least median of squares (Rousseeuw, 1984), since stray points are scattered: a third is enough.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from scalar.data.dataset import Dataset
from scalar.estimation.settings import DEFAULTS, GrossErrorSettings
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

_PART = 1.0 / 3.0  # of a scan's points that are compared with all
_LEAST_PART = 11  # points: fewer lie near some line by chance
_LINES = 150  # through pairs of points that are tried: with two points in three stray, some sixteen of them have none
_POINTS = 60  # of a scan by which the lines are compared; more change nothing
_SCANS = 100  # that are judged: a share of one half is then known to a twentieth
_ROUNDS = 10  # of refining the line; later ones change nothing
_CORE = 2.5  # standard deviations: points nearer to the line than this are its core
_CORE_TO_STD = 1.048  # of a normal law that is cut off there


def share_of_broken_lines(
    dataset: Dataset, corrupted: Array, settings: GrossErrorSettings = DEFAULTS.gross_errors
) -> float:
    """Return the share of scans that are corrupted or whose line has broken down; zero for sensors without scans.

    Args:
        dataset: Without the points that were found off their line.
        corrupted: ``(N,)`` bool, scans with too many of these.
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
    quiet = settings.least_point_error / settings.point_sigmas
    if len(points) <= _LEAST_PART:
        return False
    scatter = _line(points)[2]
    if scatter <= settings.line_breakdown * quiet:
        return False
    return scatter > settings.line_breakdown * max(_core_scatter(points), quiet)


def _line(points: Array) -> tuple[Array, float, float]:
    """Return normal ``(2,)``, distance [m] and standard deviation [m] of the line of total least squares of points ``(M, 2)`` [m]."""
    mean = points.mean(axis=0)
    off = points - mean
    squares, axes = np.linalg.eigh(off.T @ off)
    normal = axes[:, 0]
    return normal, float(normal @ mean), float(np.sqrt(max(squares[0], 0.0) / (len(points) - 2)))


def _core_scatter(points: Array) -> float:
    """Return the standard deviation [m] of the densest third of points ``(M, 2)`` [m] about the line that they lie on, as if the law were normal."""
    some = points[:: -(-len(points) // _POINTS)]
    M = len(some)
    part = max(int(np.ceil(_PART * M)), _LEAST_PART)
    if part >= M:
        return np.inf
    rng = np.random.default_rng(0)
    first = rng.integers(0, M, _LINES)
    along = some[(first + rng.integers(1, M, _LINES)) % M] - some[first]
    length = np.hypot(along[:, 0], along[:, 1])
    real = length > 0
    normals = np.stack([-along[real, 1], along[real, 0]], axis=1) / length[real, None]
    distances = np.sum(normals * some[first[real]], axis=1)
    reach = np.partition(np.abs(normals @ some.T - distances[:, None]), part - 1, axis=1)[:, part - 1]
    best = int(np.argmin(reach))
    normal, distance = normals[best], float(distances[best])
    std = float(reach[best] / ndtri(0.5 + 0.5 * part / M))
    least = max(int(np.ceil(_PART * len(points))), _LEAST_PART)
    for _ in range(_ROUNDS):
        off = np.abs(points @ normal - distance)
        core = points[off <= max(_CORE * std, float(np.partition(off, least - 1)[least - 1]))]
        normal, distance, cut_off = _line(core)
        before, std = std, _CORE_TO_STD * cut_off
        if abs(std - before) <= 1e-3 * std:
            break
    return std
