"""Poses that two tables count from different numbers: one from 0, the other from 1."""

from __future__ import annotations

import numpy as np

from scalar.data.located_table import Table
from scalar.errors import Fault


def shifted_by(ids: np.ndarray, known: np.ndarray) -> int | None:
    """Return what has to be added to the poses of one table ``(P,)`` so that clearly more of them are those of another ``(N,)``; else None.

    Numbers that overlap but for one at each end match all the same, each point with the next pose. Where one pose less on either side would be as
    good, nothing is concluded.
    """
    mine, other = np.unique(ids), np.unique(known)
    if not len(mine) or not len(other) or np.isin(mine, other).all() or np.isin(other, mine).all():
        return None
    found = {0: _without_partner(mine, other)}
    for shift in (-1, 1, int(other[0] - mine[0]), int(other[-1] - mine[-1])):
        found[shift] = _without_partner(mine + shift, other)
    best = min(found, key=lambda shift: (found[shift], abs(shift)))
    return best if best and found[best] < found[0] else None


def report_shifted(points: Table, poses: Table, faults: list[Fault]) -> bool:
    """Add a fault if the two tables count the poses from different numbers, and return whether they do."""
    ids, known = points.columns["pose"], poses.columns["pose"]
    ids, known = ids[np.isfinite(ids)], known[np.isfinite(known)]
    shift = shifted_by(ids, known)
    if shift is None:
        return False
    message = (
        f"the poses are numbered {ids.min():.15g} to {ids.max():.15g} here and {known.min():.15g} to {known.max():.15g} in {poses.file}, and with "
        f"{shift:+d} added here more of them agree: are they counted from another number? Number them alike (in an import by offset: {shift} under "
        "points.columns.pose); if the numbers are right, remove the rows without a partner"
    )
    column = getattr(points, "labels", {}).get("pose", "pose")
    faults.append(Fault(points.file, message, column=column))
    return True


def _without_partner(mine: np.ndarray, other: np.ndarray) -> int:
    """Return how many numbers stand in one of two sets only."""
    return len(np.setxor1d(mine, other))
