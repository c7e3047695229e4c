"""Rows that were copied, and readings that were repeated while the arm stood still: each counts as a measurement of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.copies import copies_in_words
from scalar.data.dataset import Dataset
from scalar.estimation.design_effect import standstills
from scalar.geometry.se3 import Array

MOST_COPIES = 0.1  # of the poses of a probe that have the angles of another one; more are contacts that were repeated (chosen)
LEAST_SHARE = 0.1  # of the rows that repeat the joint angles of the one before; a few are poses taken again as a check (chosen)


def copied_poses(dataset: Dataset) -> str:
    """Return a sentence on poses that are copies of others; empty if there are none.

    Args:
        dataset: What was measured.
    """
    angles = [q.tobytes() for q in dataset.q]
    if len(set(angles)) == len(angles):
        return ""
    if not len(dataset.points):
        return _touched_twice(dataset, angles)
    numbers = [column for column in dataset.point_columns.values() if np.issubdtype(column.dtype, np.number)]
    measured = np.column_stack([dataset.points, *numbers])
    of_poses = [rows.tobytes() for rows in np.split(measured, dataset.starts[1:-1])]
    copied = copies_in_words(zip(dataset.pose_ids, zip(angles, of_poses, strict=True), strict=True))
    return (
        f"{copied}: remove copies, because each counts as a measurement of its own, and the errors are then stated too small"
        if copied
        else ""
    )


def _touched_twice(dataset: Dataset, angles: Sequence[bytes]) -> str:
    """Return the sentence on poses of a probe that have the joint angles of another one; empty if angles are so coarse that contacts may repeat them.

    Args:
        dataset: What was touched.
        angles: The joint angles of each pose, as bytes.
    """
    first: dict[bytes, int] = {}
    pairs = [(k, i) for i, own in enumerate(angles) if (k := first.setdefault(own, i)) != i]
    if len(pairs) > MOST_COPIES * len(angles):
        return ""
    one, other = (int(dataset.pose_ids[i]) for i in pairs[0])
    more = f", and {len(pairs) - 1} more such pairs" if len(pairs) > 1 else ""
    return (
        f"poses {one} and {other} have the same joint angles to the last digit{more}: if a row was written twice, remove or correct one of the two, "
        "because each counts as a contact of its own"
    )


def reads_again(standstill: Array) -> bool:
    """Return whether more than a few rows are further readings of a standstill; ``standstill`` ``(N,)`` is that of each row (``standstills``)."""
    return len(standstill) - (standstill.max(initial=-1) + 1) >= LEAST_SHARE * len(standstill)


def repeated_readings(dataset: Dataset) -> str:
    """Return a sentence on rows whose joint angles are those of the row before; empty if fewer than ``LEAST_SHARE`` of the rows are such.

    Readings of an arm that stands still share the error that its repeatability leaves, so their residuals are alike even if the model lacks nothing.

    Args:
        dataset: What was measured. Poses without points of their own, as those of a probe, may well be repeated.
    """
    if not len(dataset.points) or len(dataset.q) < 2:
        return ""
    order = dataset.known_poses.order
    rows = np.argsort(order, kind="stable")
    standstill = standstills(dataset.q, order)
    if not reads_again(standstill):
        return ""
    again = np.flatnonzero(np.diff(standstill[rows]) == 0) + 1
    one, other = (int(dataset.pose_ids[rows[k]]) for k in (again[0] - 1, again[0]))
    return (
        f"{len(again)} of {len(rows)} rows have the joint angles of the row before (first pose {other}, after pose {one}). If the arm stood still in "
        "between, they are readings of one pose and share its error: the standard errors count that, but structure may be found where there is none. "
        "Keep their mean, or one of them (`first_of_each` of a mapping). If the arm left the pose and came back, all is well"
    )
