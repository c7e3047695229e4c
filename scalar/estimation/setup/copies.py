"""Poses that repeat another one with its measurements to the last digit, which noise never does: rows that were copied count as new measurements."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset


def copies_in_words(dataset: Dataset) -> str:
    """Return a sentence on poses that are copies of others; empty if there are none.

    Args:
        dataset: What was measured. Poses without points of their own, as those of a probe, may well be repeated.
    """
    if not len(dataset.points):
        return ""
    measured = np.column_stack([dataset.points, *_numeric(dataset)])
    first: dict[bytes, int] = {}
    pairs = []
    for i, (start, stop) in enumerate(zip(dataset.starts[:-1], dataset.starts[1:], strict=True)):
        key = dataset.q[i].tobytes() + measured[start:stop].tobytes()
        same = first.setdefault(key, i)
        if same != i:
            pairs.append((same, i))
    if not pairs:
        return ""
    one, other = (dataset.pose_ids[i] for i in pairs[0])
    more = f", and {len(pairs) - 1} more such pairs" if len(pairs) > 1 else ""
    return (
        f"poses {one} and {other} have the same joint angles and measurements to the last digit{more}: remove copies, because each counts as a "
        "measurement of its own, and the errors are then stated too small"
    )


def _numeric(dataset: Dataset) -> list[np.ndarray]:
    """Return the further columns of the points that hold numbers."""
    return [values for values in dataset.point_columns.values() if np.issubdtype(values.dtype, np.number)]
