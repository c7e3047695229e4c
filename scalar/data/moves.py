"""The moves between poses, from the order of acquisition: by how much each joint moved to a pose, in which direction, and how far since it turned.

Each move is assumed to be direct. A joint that stands still keeps the direction of its last move. After a gap in the order, and at the
first pose of a session, the move is not known.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from scalar.data.formats import COMMANDED
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import BoolArray
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import pandas as pd

STILL = 2e-3  # rad, a tenth of a degree: a joint that moves by less counts as standing still (under load it may yield by as much)
STILL_TRAVEL = 2e-4  # m, the same of a joint that slides: what a tenth of a degree is at a lever of 0.1 m

# Travels of a joint [rad or m] over which the effect of its earlier moves on friction decays to about a third (1/e).
TRAVELS = (0.02, 0.06, 0.2, 0.6)


def step_column(joint: int) -> str:
    """Return the name of the column with the last step [rad, m] of a joint, counted from 1; the step is 0 where it is not known."""
    return f"step_q{joint}"


def side_column(joint: int) -> str:
    """Return the name of the column with the sign of the last move of a joint, counted from 1; the sign is 0 where it is not known."""
    return f"side_q{joint}"


def wind_up_column(joint: int, travel: float) -> str:
    """Return the name of the column with the wind-up, -1 to 1, of a joint, counted from 1, by one of ``TRAVELS``; it is 0 where it is not known."""
    return f"wind_up_q{joint}_{travel:g}"


def passing_column(joint: int) -> str:
    """Return the name of the column with the velocity [rad/s, m/s] with which a joint, counted from 1, passes a pose; 0 where it is not known."""
    return f"passing_q{joint}"


def last_move_columns(n_joints: int) -> list[str]:
    """Return the names of the columns with the last move of each of n joints: its step and its sign."""
    joints = range(1, n_joints + 1)
    return [*map(step_column, joints), *map(side_column, joints)]


def move_columns(n_joints: int) -> list[str]:
    """Return the names of all columns that the moves of n joints have."""
    joints = range(1, n_joints + 1)
    wind_up = [wind_up_column(joint, travel) for travel in TRAVELS for joint in joints]
    return [*last_move_columns(n_joints), *wind_up, *map(passing_column, joints)]


def joint_angles(frame: pd.DataFrame, n_joints: int) -> Array:
    """Return the joint angles and travels q1..qn of a table, ``(N, n)`` [rad, m]."""
    table = cast(Any, frame)
    q = np.empty((len(table), n_joints))
    for i in range(n_joints):
        q[:, i] = table[f"q{i + 1}"].to_numpy(dtype=float)
    return q


def still(slides: Sequence[bool] | BoolArray) -> Array:
    """Return by how much a joint may move and count as standing still, ``(n,)`` [rad, m].

    Args:
        slides: ``(n,)``, which joints are prismatic.
    """
    return np.where(np.asarray(slides, dtype=bool), STILL_TRAVEL, STILL)


def moves(
    frame: pd.DataFrame, slides: Sequence[bool] | BoolArray, q: Array | None = None
) -> dict[str, Array]:
    """Return the columns of the moves to the poses of a table, ``(N,)`` each.

    If the table has these columns already, they are returned as they are: they were computed before poses were taken out of it. The others are zero
    in a table that has the last moves alone, as former versions wrote them.

    Args:
        frame: Columns q1..qn [rad, m], ``order`` (without it: the order of the rows), ``session`` (optional).
        slides: ``(n,)``, which joints are prismatic.
        q: ``(N, n)`` [rad, m], the columns q1..qn where they have been taken from the table already, or None.
    """
    names = move_columns(len(slides))
    table = cast(Any, frame)
    if all(name in table.columns for name in last_move_columns(len(slides))):
        none = np.zeros(len(table))
        return {name: table[name].to_numpy(dtype=float) if name in table.columns else none for name in names}
    q = joint_angles(frame, len(slides)) if q is None else q
    order = table["order"].to_numpy(dtype=float) if "order" in table.columns else np.arange(float(len(q)))
    session, time = (
        table[name].to_numpy() if name in table.columns else None for name in ("session", "time")
    )
    return moves_in_order(q, order, slides, session, None if time is None else time.astype(float))


def rows_with_moves(
    frame: pd.DataFrame, rows: Array, columns: Mapping[str, Array], n_joints: int
) -> pd.DataFrame:
    """Return some rows of a table of poses with the columns of the moves that led to them.

    Args:
        frame: The table; it may have these columns already.
        rows: ``(k,)``, the numbers of the rows.
        columns: With those of ``moves`` for all rows.
        n_joints: Number of joints, n.
    """
    import pandas as pd

    table = cast(Any, frame).iloc[rows].reset_index(drop=True)
    missing = [name for name in move_columns(n_joints) if name not in frame.columns]
    if not missing:
        return table
    # All at once: to add one column after the other takes many times as long.
    return pd.concat([table, pd.DataFrame({name: columns[name][rows] for name in missing})], axis=1)


def moves_in_order(
    q: Array,
    order: Array,
    slides: Sequence[bool] | BoolArray,
    session: Array | None = None,
    time: Array | None = None,
) -> dict[str, Array]:
    """Return the columns of the moves to poses, ``(N,)`` each.

    Args:
        q: ``(N, n)`` [rad, m].
        order: ``(N,)``, in which the poses were taken.
        slides: ``(n,)``, which joints are prismatic.
        session: ``(N,)``, to which each belongs; None for a single one.
        time: ``(N,)`` [s], at which each was measured; None if it is not recorded.
    """
    rows = np.argsort(order, kind="stable")
    known = ~_gaps(order[rows])
    if session is not None:
        known[1:] &= session[rows][1:] == session[rows][:-1]
    step = np.zeros_like(q)
    step[rows[1:]] = np.where(known[1:, None], np.diff(q[rows], axis=0), 0.0)
    side = np.zeros_like(q)
    side[rows] = _last_sides(step[rows], known, still(slides))
    wind_up = np.zeros((len(TRAVELS), *q.shape))
    wind_up[:, rows] = _wind_up(step[rows], known, TRAVELS)
    passing = np.zeros_like(q)
    if time is not None:
        passing[rows] = _passing(q[rows], time[rows], known)
    return dict(
        zip(move_columns(q.shape[1]), np.column_stack([step, side, *wind_up, passing]).T, strict=True)
    )


def speeds(columns: Mapping[str, Array], slides: Sequence[bool] | BoolArray, n_poses: int) -> Array:
    """Return the speed of each joint in the move to each pose, ``(N, n)`` from -1 to 1, as a share of the fastest joint's; 0 where it is not known.

    The joints of an industrial robot start and arrive together. So the speed of a joint is its step over the duration of the move, and the joint
    that moves farthest decides the duration. The joints of one kind, that turn or that slide, are compared with one another.

    Args:
        columns: With those of ``moves``; steps that are missing count as zero.
        slides: ``(n,)``, which joints are prismatic.
        n_poses: N.
    """
    none = np.zeros(n_poses)
    steps = np.stack([columns.get(step_column(j + 1), none) for j in range(len(slides))], axis=1)
    found = np.zeros_like(steps)
    for kind in (False, True):
        own = np.asarray(slides) == kind
        farthest = np.abs(steps[:, own]).max(axis=1, initial=0.0)[:, None]
        least = STILL_TRAVEL if kind else STILL
        found[:, own] = np.where(farthest > least, steps[:, own] / np.maximum(farthest, least), 0.0)
    return found


def _passing(q: Array, time: Array, known: Array) -> Array:
    """Return the velocities ``(N, n)`` of an arm that passes the poses without a stop: from the pose before to the pose after, over their times.

    Args:
        q: ``(N, n)`` [rad, m], in order of acquisition.
        time: ``(N,)`` [s].
        known: ``(N,)`` bool, whether the pose before is known.
    """
    found = np.zeros_like(q)
    between = known[1:-1] & known[2:]
    took = time[2:] - time[:-2]
    between &= took > 0
    found[1:-1][between] = (q[2:] - q[:-2])[between] / took[between, None]
    return found


def _gaps(order: Array) -> Array:
    """Return which poses ``(N,)`` bool have no pose just before them: the first and, if the order counts poses, those after a jump."""
    gap = np.zeros(len(order), dtype=bool)
    gap[:1] = True
    steps = np.diff(order)
    counted = len(steps) > 0 and np.all(order == np.round(order)) and np.median(steps) == 1.0
    if counted:
        gap[1:] = steps > 1.0
    return gap


def _last_sides(step: Array, known: Array, least: Array) -> Array:
    """Return the sign of each joint's last move ``(N, n)`` by more than ``least`` ``(n,)``, in order of acquisition.

    It is 0 before a joint first moves and after a gap.
    """
    sign = np.where(np.abs(step) > least, np.sign(step), 0.0)
    decides = (sign != 0.0) | ~known[:, None]
    last = np.maximum.accumulate(np.where(decides, np.arange(len(step))[:, None], 0), axis=0)
    return np.take_along_axis(sign, last, axis=0)


def _wind_up(step: Array, known: Array, travels: Sequence[float]) -> Array:
    """Return the wind-up of each joint by each of T travels, ``(T, N, n)``, in order of acquisition, 0 before the first move and after a gap.

    Over a step it approaches the sign of the step exponentially, ``w -> s + (w - s) exp(-|step| / travel)``: the friction of Dahl (1968), whose
    force over displacement has this solution. Such steps are linear maps of w; they are composed two by two, then four by four, and so on.

    Args:
        step: ``(N, n)`` [rad, m].
        known: ``(N,)`` bool, whether the pose before is known.
        travels: In which the wind-up approaches its limit to a third [rad, m].
    """
    factor = np.where(known[:, None], np.exp(-np.abs(step) / np.array(travels)[:, None, None]), 0.0)
    added = np.where(known[:, None], np.sign(step) * (1.0 - factor), 0.0)
    reach = 1
    while reach < len(step):
        added[:, reach:] = added[:, reach:] + factor[:, reach:] * added[:, :-reach]
        factor[:, reach:] = factor[:, reach:] * factor[:, :-reach]
        reach *= 2
    return added


def with_commanded_joints(poses: pd.DataFrame, n_joints: int) -> pd.DataFrame:
    """Return the rows of poses.csv with the commanded joint positions, ``qc1..qcn``, in place of those logged, ``q1..qn`` [rad; m].

    Raises:
        InvalidInput: There are no such columns.
    """
    names = {f"q{i + 1}": f"{COMMANDED}{i + 1}" for i in range(n_joints)}
    missing = [name for name in names.values() if name not in poses.columns]
    if missing:
        message = "the column is missing: no commanded joint positions are recorded; leave out --commanded"
        raise InvalidInput(Fault("poses.csv", message, 1, missing[0]))
    logged = poses.drop(columns=[*names, *move_columns(n_joints)], errors="ignore")
    return logged.rename(columns={column: name for name, column in names.items()})
