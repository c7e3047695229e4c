"""A joint whose logged position stays the same in successive poses that contradict the others: it was not logged there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.dataset import Dataset
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM

_LEAST_RUN = 5  # successive poses, chosen: a program may well leave a joint alone for a few
_LONG_RUN = 10  # successive poses, chosen: of a joint whose position never recurs elsewhere
_MOST_OFF = 0.5  # share of the poses of the run that contradict the others, chosen: some fit by chance


def stuck_joint_in_words(dataset: Dataset, outliers: Sequence[int]) -> str:
    """Return a sentence if a joint has one position in a run of poses, most of which contradict the others, as most outliers do; else nothing.

    Args:
        dataset: Poses in the order of acquisition.
        outliers: Ids of the poses that contradict the others.
    """
    off = np.isin(dataset.pose_ids, outliers)
    for j, column in enumerate(dataset.q.T):
        for run in _runs(column):
            mine = off[run]
            if mine.mean() < _MOST_OFF or mine.sum() < _MOST_OFF * off.sum() or np.ptp(column) == 0.0:
                continue
            value = (
                f"{column[run[0]] / MM:.6g} mm"
                if dataset.robot.slides[j]
                else f"{column[run[0]] / DEG:.6g} degrees"
            )
            first, last = dataset.pose_ids[run[[0, -1]]]
            return (
                f"joint {j + 1} has the same position, {value}, from pose {first} to pose {last}, and {mine.sum()} of these {len(run)} poses "
                f"contradict all others: q{j + 1} was probably not logged there; remove these poses, or put in what the joint did"
            )
    return ""


def stands_still_for_long(dataset: Dataset) -> str:
    """Return a sentence if a joint has one position in a long run of poses in which others move, and never twice the same elsewhere; else nothing.

    Where a joint moves one at a time, or on a grid, its positions recur.

    Args:
        dataset: Poses in the order of acquisition.
    """
    if np.count_nonzero(np.diff(dataset.q, axis=0) == 0.0) < _LONG_RUN - 1:
        return ""
    for j, column in enumerate(dataset.q.T):
        for run in _runs(column):
            elsewhere = np.delete(column, run)
            others = np.delete(dataset.q[run], j, axis=1)
            if (
                len(run) < _LONG_RUN
                or len(elsewhere) < len(run)
                or len(np.unique(elsewhere)) < len(elsewhere)
                or len(np.unique(others, axis=0)) < len(run)
            ):
                continue
            first, last = dataset.pose_ids[run[[0, -1]]]
            return (
                f"joint {j + 1} has the same position in the {len(run)} poses from {first} to {last}, in which other joints move, and another one "
                f"in each of the other poses: was q{j + 1} logged there?"
            )
    return ""


def _runs(column: Array) -> list[Array]:
    """Return the rows of each run of equal numbers in a column ``(N,)`` that is long enough."""
    parts = np.split(np.arange(len(column)), np.flatnonzero(np.diff(column) != 0.0) + 1)
    return [part for part in parts if len(part) >= _LEAST_RUN]
