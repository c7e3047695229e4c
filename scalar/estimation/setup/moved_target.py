"""A tracker, planes or an arm that were set up anew during the campaign, without a column ``session`` in poses.csv.

From some pose on, the target has another place relative to the base. The poses before it and those after it each fit; together they do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.trial import MOST_POSES, first_look, full_fit
from scalar.geometry.se3 import Array

LEAST_POSES = 10  # in each part, before a tracker: with fewer, a place of its own may explain gross errors
LEAST_SCANS = 30  # the same with planes, which have a place of their own each
BREAKS = 12  # tried at once; the next ones lie between the neighbours of the best


def moved_targets(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which the target stands elsewhere from a pose on, the pose that leaves the smallest residual."""
    k = _best_break(dataset)
    if k is None:
        return
    pose = dataset.pose_ids[k]
    what = "the planes or the arm's base stand" if dataset.planes else "the tracker or the arm's base stands"
    yield Alternative(
        "moved_target",
        f"pose {pose}",
        f"from pose {pose} on {what} elsewhere",
        "with a session of its own from there on",
        f"write a column session into poses.csv whose value changes at pose {pose}",
        _with_break(dataset, k),
    )


def _best_break(dataset: Dataset) -> int | None:
    """Return the row (from 0) of the first pose after the move that leaves the smallest residual; None if there are too few poses.

    The errors of the nominal arm hide a small move at single poses. The last rows are therefore compared with the arm as fitted with the best break.
    """
    least = LEAST_SCANS if dataset.planes else LEAST_POSES
    first, last = least, dataset.n_poses - least
    if first > last:
        return None
    k = _least_residual(dataset, first, last)
    trial = full_fit(_with_break(dataset, k))
    if trial is None:
        return k
    fitted = replace(dataset, robot=trial.model.robot)
    return _least_residual(fitted, max(first, k - BREAKS), min(last, k + BREAKS))


def _least_residual(dataset: Dataset, low: int, high: int) -> int:
    """Return the row from ``low`` to ``high`` at which a move leaves the smallest residual, all tried poses counted."""
    while True:
        tried = np.unique(np.linspace(low, high, BREAKS).round().astype(int))
        rows = _rows_about(dataset.n_poses, low, high)
        at = int(np.argmin([first_look(_with_break(dataset, int(k)).subset(rows)).of_all for k in tried]))
        if high - low < BREAKS:
            return int(tried[at])
        low, high = int(tried[max(at - 1, 0)]), int(tried[min(at + 1, len(tried) - 1)])


def _rows_about(n_poses: int, low: int, high: int) -> Array:
    """Return at most ``MOST_POSES`` rows: half of them over all poses, the rest between two rows, where they are denser."""
    everywhere = np.linspace(0, n_poses - 1, MOST_POSES // 2)
    between = np.linspace(low - 1, high, MOST_POSES // 2)
    return np.unique(np.concatenate([everywhere, between]).round().astype(int))


def _with_break(dataset: Dataset, k: int) -> Dataset:
    """Return the dataset with a session of its own from row ``k`` on."""
    before = np.zeros(dataset.n_poses, dtype=int) if dataset.session is None else dataset.session
    session = 2 * before + (np.arange(dataset.n_poses) >= k)
    return replace(dataset, poses=dataset.poses.assign(session=session))
