"""Points that are off their own scan's line: found without any model of the robot, and removed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.settings import DEFAULTS, GrossErrorSettings
from scalar.geometry.se3 import Array
from scalar.kernels.contacts import off_lines
from scalar.sensors import kind_of
from scalar.sensors.robust_scale import MAD_TO_STD

_LEAST_SCALE = 1e-9  # m: keeps the weights of a noise-free scan finite
_ROUNDS = 12  # of reweighting towards least absolute deviations; later ones change nothing
_LEAST_RATIO = 0.3  # of the scale: nearer to the line, points weigh the same


def without_outlying_points(
    dataset: Dataset, settings: GrossErrorSettings = DEFAULTS.gross_errors
) -> tuple[Dataset, int, Array]:
    """Return the dataset without points that are off their own scan's line, their number, and which scans are corrupted.

    Each scan's line is found by iteratively reweighted least squares, which approach the line of least absolute distances; it tolerates about
    a third of wrong points. A scan with a larger share off its line (``settings.corrupted_share``) counts as corrupted, and all its points stay.

    Returns:
        The dataset, the number of removed points, and ``(N,)`` bool, which scans are corrupted.
    """
    counts = np.diff(dataset.starts)
    corrupted = np.zeros(dataset.n_poses, dtype=bool)
    if not kind_of(dataset).scans or counts.max(initial=0) < settings.least_points:
        return dataset, 0, corrupted
    first = dataset.starts[:-1]
    scan = np.repeat(np.arange(len(counts)), counts)
    distance = np.zeros(len(dataset.points))
    weight = np.ones(len(dataset.points))
    scale = np.full(len(counts), np.inf)
    for _ in range(_ROUNDS):
        distance = np.abs(_line_distance(dataset.points, weight, first, scan))
        scale = np.maximum(MAD_TO_STD * _median_within(distance, scan, first, counts), _LEAST_SCALE)
        weight = 1.0 / np.maximum(distance / scale[scan], _LEAST_RATIO)
    floor = np.median(scale)  # the scatter of a short scan may be small by chance
    limit = np.maximum(settings.point_sigmas * np.maximum(scale, floor), settings.least_point_error)
    off = (distance > limit[scan]) & (counts[scan] >= settings.least_points)
    share = np.add.reduceat(off.astype(float), first) / counts
    corrupted = share > settings.corrupted_share
    drop = off & ~corrupted[scan]
    if not drop.any():
        return dataset, 0, corrupted
    kept = counts - np.add.reduceat(drop.astype(int), first)
    return (
        replace(dataset, points=dataset.points[~drop], starts=np.r_[0, np.cumsum(kept)]),
        int(drop.sum()),
        corrupted,
    )


def scatter_about_lines(dataset: Dataset) -> Array:
    """Return the standard deviation of the points of every scan about its own line of least squares, ``(N,)`` [m]; each has more than two points."""
    counts = np.diff(dataset.starts)
    compiled = off_lines(dataset.points, dataset.starts)
    if compiled is not None:
        return np.sqrt(compiled / (counts - 2))
    first, scan = dataset.starts[:-1], np.repeat(np.arange(len(counts)), counts)
    off = _line_distance(dataset.points, np.ones(len(dataset.points)), first, scan)
    return np.sqrt(np.add.reduceat(off * off, first) / (counts - 2))


def _line_distance(points: Array, weight: Array, first: Array, scan: Array) -> Array:
    """Return the signed distance of every point to its scan's weighted line of total least squares, in metres.

    Args:
        points: ``(M, 2)`` [m], of all scans.
        weight: ``(M,)``.
        first: ``(N,)``, index of the first point of each scan.
        scan: ``(M,)``, the scan of each point.
    """
    total = np.add.reduceat(weight, first)
    # Column by column, since sums along the long axis of a table of two columns are slow.
    x, z = (each - (np.add.reduceat(weight * each, first) / total)[scan] for each in points.T.copy())
    sxx, sxz, szz = (np.add.reduceat(weight * u * v, first) for u, v in ((x, x), (x, z), (z, z)))
    angle = 0.5 * np.arctan2(2 * sxz, sxx - szz)
    return z * np.cos(angle)[scan] - x * np.sin(angle)[scan]


def _median_within(values: Array, scan: Array, first: Array, counts: Array) -> Array:
    """Return the median ``(N,)`` of the values ``(M,)`` of each scan, the larger of the middle two; other arguments as for ``_line_distance``."""
    if np.all(counts == counts[0]):  # much faster than sorting the values of all scans together
        middle = int(counts[0]) // 2
        return np.partition(values.reshape(len(counts), -1), middle, axis=1)[:, middle]
    order = np.lexsort((values, scan))
    return values[order][first + counts // 2]
