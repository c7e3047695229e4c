"""A session that begins too late or too early in the column ``session``: the poses between contradict their own session, and fit the other one.

A diagnosis sets such poses aside one by one, as gross errors. That they end or begin at a boundary of the sessions, and fit the session on its other
side, shows what they are.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import distances_under
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.geometry.se3 import Array

LEAST_POSES = 3  # chosen: of fewer poses that were set aside at a boundary, each may be a gross error
AS_GOOD = 3.0  # times the median distance of the poses that were kept: nearer, a pose fits the other session


def misplaced_boundaries(dataset: Dataset, set_aside: Collection[int], model: Model) -> list[Suspicion]:
    """Return a suspicion for each boundary of two sessions at which poses that were set aside fit the session on its other side.

    Args:
        dataset: As it was given, before cleaning.
        set_aside: Ids of the poses that were set aside.
        model: Fitted to the others, without effects.
    """
    session = dataset.session
    if session is None or not set_aside:
        return []
    aside = np.isin(dataset.pose_ids, list(set_aside))
    found: list[Suspicion] = []
    for first in (np.flatnonzero(np.diff(session)) + 1).tolist():
        before = _rows_aside(aside, session, range(first - 1, -1, -1))
        after = _rows_aside(aside, session, range(first, dataset.n_poses))
        found += _suspicion(dataset, aside, model, first, np.sort(before), first)
        found += _suspicion(dataset, aside, model, first, after, first - 1)
    return found


def _rows_aside(aside: Array, session: Array, rows: range) -> Array:
    """Return the successive rows from the first of ``rows`` on that were set aside, as long as they are of one session."""
    run: list[int] = []
    for row in rows:
        if not aside[row] or session[row] != session[rows[0]]:
            break
        run.append(row)
    return np.array(run, dtype=int)


def _suspicion(
    dataset: Dataset, aside: Array, model: Model, first: int, rows: Array, neighbour: int
) -> list[Suspicion]:
    """Return a suspicion if the poses of some rows fit the session of a neighbouring row, and not their own.

    Args:
        dataset: As it was given.
        aside: ``(N,)`` bool, which poses were set aside.
        model: Fitted to the others.
        first: Row of the first pose of the later session.
        rows: ``(k,)``, successive rows that were set aside, directly before ``first`` or from it on.
        neighbour: The row on the other side of the boundary.
    """
    if len(rows) < LEAST_POSES:
        return []
    labels = dataset.poses["session"].to_numpy(copy=True)
    labels[rows] = labels[neighbour]
    moved = replace(dataset, poses=dataset.poses.assign(session=labels))
    try:
        own, other = distances_under(dataset, model), distances_under(moved, model)
    except (ScalarError, ValueError, IndexError, np.linalg.LinAlgError):
        return []
    limit = AS_GOOD * float(np.median(other[~aside]))
    if np.median(other[rows]) > limit or np.median(own[rows]) <= limit:
        return []
    ids, late = dataset.pose_ids, rows[0] < first
    begins = ids[rows[0]] if late else ids[rows[-1] + 1] if rows[-1] + 1 < len(ids) else None
    where = f"the session that {'begins at' if late else 'ends at'} pose {ids[neighbour]}"
    remedy = "" if begins is None else f": let it change at pose {begins} if that is when the set-up changed"
    between = f"poses {ids[rows[0]]} to {ids[rows[-1]]}"
    figures = (
        f"by {in_mm(np.median(own[rows]))} mm, and fit {where} ({in_mm(np.median(other[rows]))} mm, medians)"
    )
    return [
        Suspicion(
            "session",
            f"pose {ids[first]}",
            f"{between} are set aside because they contradict their own session {figures}: the column session of poses.csv probably changes too "
            f"{'late' if late else 'early'}, at pose {ids[first]}{remedy}",
            float(np.median(own[rows])),
            float(np.median(other[rows])),
        )
    ]
