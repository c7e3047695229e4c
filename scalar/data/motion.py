"""Whether the joints move at all, and the measured points with them.

A column that holds the same number in all rows was often not recorded but filled in. A campaign may well leave single joints alone; poses or
points that are all the same determine nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.errors import Fault

# [rad or m] chosen: encoders and sensors scatter by less, and joints that are moved move by far more.
_STILL = 1e-4
_SEVERAL = 3  # poses; fewer are refused because they are few
_ONE_POSITION = 2e-3  # chosen [rad or m]: positions that differ by less from their neighbours are one
# Chosen: numbers of positions of a joint that stands at few; at two, a scale is any error.
_FEW = range(3, 13)


def still_joints(q: np.ndarray) -> list[int]:
    """Return the joints, counted from 1, that have the same position in all poses; none where there are hardly any poses.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides].
    """
    if len(q) < _SEVERAL:
        return []
    return [int(i) + 1 for i in np.flatnonzero(np.ptp(q, axis=0) < _STILL)]


def positions(q: np.ndarray) -> np.ndarray:
    """Return the index ``(N,)`` of the position at which a joint stands in each pose, from 0 in ascending order.

    Args:
        q: ``(N,)`` [rad; m of a joint that slides].
    """
    ascending = np.argsort(q, kind="stable")
    index = np.zeros(len(q), dtype=int)
    index[ascending[1:]] = np.cumsum(np.diff(q[ascending]) > _ONE_POSITION)
    return index


def at_few_positions(q: np.ndarray) -> list[int]:
    """Return the joints, counted from 1, that stand at a few positions in all poses, as on a grid.

    Where many poses lie close to one another, neighbours are one position although they cover a range. Such a joint stands at no few positions.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides].
    """
    return [j + 1 for j in range(q.shape[1]) if _are_few(q[:, j])]


def _are_few(q: np.ndarray) -> bool:
    """Return whether the numbers ``(N,)`` are a few, each with a small scatter."""
    index = positions(q)
    if int(index.max(initial=-1)) + 1 not in _FEW:
        return False
    widths = [float(np.ptp(q[index == k])) for k in range(int(index.max()) + 1)]
    return max(widths) <= 2.0 * _ONE_POSITION


def still_in_words(joints: Sequence[int]) -> str:
    """Return a clause that names joints which never move, such as ``joint 6 has the same position in all poses``; empty if there are none."""
    if not joints:
        return ""
    *others, last = map(str, joints)
    if not others:
        return f"joint {last} has the same position in all poses"
    return f"joints {', '.join(others)} and {last} have the same position in all poses"


def still_clause(q: np.ndarray) -> str:
    """Return the end of a refusal that says which joints never move, since their positions may have been filled in; empty if all move.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides].
    """
    joints = still_joints(q)
    if not joints:
        return ""
    moved = "they did move, their columns were" if len(joints) > 1 else "it did move, its column was"
    return f"; {still_in_words(joints)}: if {moved} not recorded"


def faults_without_motion(
    q: np.ndarray, points: np.ndarray, items: np.ndarray | None, points_file: str
) -> list[Fault]:
    """Return a fault if all poses are the same, and one if all points are.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides].
        points: ``(P, k)`` [m], as the sensor's table has them; no rows for a sensor without a table.
        items: ``(P,)``, which of several targets each point is of; None for a single one.
        points_file: Name of the table of points, for messages.
    """
    faults = []
    if q.shape[1] and len(still_joints(q)) == q.shape[1]:
        message = (
            f"the joints have the same positions in all {len(q)} poses: such data determine nothing of an arm; check how the positions were "
            "recorded, or measure poses that differ in all joints"
        )
        faults.append(Fault("poses.csv", message))
    of_each = [points] if items is None else [points[items == item] for item in np.unique(items)]
    if len(points) >= _SEVERAL and all(float(np.ptp(column)) < _STILL for own in of_each for column in own.T):
        message = (
            f"all {len(points)} points are the same: such data determine nothing of an arm; check how the points were recorded, and whether "
            "the sensor measured anew at each pose"
        )
        faults.append(Fault(points_file, message))
    return faults
