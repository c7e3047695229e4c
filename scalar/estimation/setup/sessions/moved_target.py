"""A tracker, planes or an arm that were set up anew during the campaign, without a column ``session`` in poses.csv.

From some pose on, the target has another place relative to the base. The poses before it and those after it each fit; together they do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.sessions.first_pose_after import best_break

LEAST_POSES = 10  # in each part, before a tracker: with fewer, a place of its own may explain gross errors
LEAST_SCANS = 30  # the same with planes, which have a place of their own each


def moved_targets(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which the target stands elsewhere from a pose on, the pose that leaves the smallest residual."""
    least = LEAST_SCANS if dataset.planes else LEAST_POSES
    k = best_break(dataset, _with_break, least)
    if k is None:
        return
    pose = dataset.pose_ids[k]
    what = "the planes or the arm's base stand" if dataset.planes else "the tracker or the arm's base stands"
    yield Alternative(
        "moved_target",
        f"pose {pose}",
        f"from pose {pose} on {what} elsewhere",
        "with a session of its own from there on",
        _remedy(dataset, k),
        _with_break(dataset, k),
        file="poses.csv",
    )


def _remedy(dataset: Dataset, k: int) -> str:
    """Return what to do about a move before row ``k``; a boundary of two sessions that follows may be the same move, stated too late."""
    ids = dataset.pose_ids
    if dataset.session is None:
        return f"write a column session into poses.csv whose value changes at pose {ids[k]}"
    later = np.flatnonzero(np.diff(dataset.session)) + 1
    later = later[later > k]
    late = (
        f"; it changes at pose {ids[later[0]]}, which is too late if that is the same move"
        if len(later)
        else ""
    )
    return f"let the value of the column session in poses.csv change at pose {ids[k]}{late}"


def _with_break(dataset: Dataset, k: int) -> Dataset:
    """Return the dataset with a session of its own from row ``k`` on."""
    before = np.zeros(dataset.n_poses, dtype=int) if dataset.session is None else dataset.session
    session = 2 * before + (np.arange(dataset.n_poses) >= k)
    return replace(dataset, poses=dataset.poses.assign(session=session))
