"""Rows that were copied: each counts as a measurement of its own."""

from __future__ import annotations

import numpy as np

from scalar.data.copies import copies_in_words
from scalar.data.dataset import Dataset


def copied_poses(dataset: Dataset) -> str:
    """Return a sentence on poses that are copies of others; empty if there are none.

    Args:
        dataset: What was measured. Poses without points of their own, as those of a probe, may well be repeated.
    """
    angles = [q.tobytes() for q in dataset.q]
    if not len(dataset.points) or len(set(angles)) == len(angles):
        return ""
    numbers = [column for column in dataset.point_columns.values() if np.issubdtype(column.dtype, np.number)]
    measured = np.column_stack([dataset.points, *numbers])
    of_poses = [rows.tobytes() for rows in np.split(measured, dataset.starts[1:-1])]
    told = copies_in_words(zip(dataset.pose_ids, zip(angles, of_poses, strict=True), strict=True))
    return (
        f"{told}: remove copies, because each counts as a measurement of its own, and the errors are then stated too small"
        if told
        else ""
    )
