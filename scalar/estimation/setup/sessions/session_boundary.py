"""A session that begins too late or too early in the column ``session``: the poses between contradict their own session, and fit the other one.

A diagnosis sets such poses aside one by one, as gross errors. That they end or begin at a boundary of the sessions, and fit the session on its other
side, shows what they are. Where planes are scanned one after the other, these poses may be the only ones of their plane in the other session. A plane
is then fitted to them, and that they lie on it shows the same. If they are few and all on one plane, a diagnosis may also have found that this plane
moved.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects import Effect
from scalar.effects.acquisition import order_and_time
from scalar.errors import ScalarError
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import distances_under
from scalar.estimation.residuals import Residuals
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import measure

LEAST_POSES = 3  # chosen: of fewer poses that were set aside at a boundary, each may be a gross error
# Number of poses, chosen: a plane has three coordinates, and fewer contacts with it prove nothing.
LEAST_OF_NEW_PLANE = 6
NEAR_BOUNDARY = 0.2  # chosen, of a session: a change in its last or first fifth may be the one at which the session should change
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
        own, other = _distances(dataset, model), _distances(moved, model)
    except (ScalarError, ValueError, np.linalg.LinAlgError):
        return []
    limit = AS_GOOD * float(np.median(other[~aside]))
    if not (np.median(other[rows]) <= limit < np.median(own[rows])):
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


def _distances(dataset: Dataset, model: Model) -> Array:
    """Return the distance ``(N,)`` [m] of each pose from its target; a plane that the model lacks in a session is fitted to its poses.

    If such a plane has fewer than ``LEAST_OF_NEW_PLANE`` poses, their distance is infinite.
    """
    measurement = measure(dataset)
    guess, known = measurement.initial_target(dataset), model.target
    if not isinstance(guess, Planes) or not isinstance(known, Planes) or guess.names == known.names:
        return distances_under(dataset, model)
    rigid = Model(model.robot, model.nominal, model.reference_rotation, model.sensor, guess)
    T_base_sensor = Residuals.of(dataset, rigid, measurement).kinematics(rigid).T_base_sensor
    found = measurement.fitted_target(T_base_sensor, guess)
    normals, distances = found.normals.copy(), found.distances.copy()
    for k, name in enumerate(guess.names):
        if name in known.names:
            at = known.names.index(name)
            normals[k], distances[k] = known.normals[at], known.distances[at]
    target = Planes.at(guess.names, normals, distances)
    result = distances_under(dataset, replace(rigid, target=target))
    counts = np.bincount(measurement.target_index, minlength=len(guess.names))
    unseen = [
        k for k, name in enumerate(guess.names) if name not in known.names and counts[k] < LEAST_OF_NEW_PLANE
    ]
    result[np.isin(measurement.target_index, unseen)] = np.inf
    return result


def boundaries_near_changes(dataset: Dataset, effects: Sequence[Effect]) -> list[Suspicion]:
    """Return a suspicion for each change of the set-up that was found shortly before or after a session begins: both may be one change.

    Args:
        dataset: As it was given, before cleaning.
        effects: Those that a diagnosis found; only changes at one moment (``target`` has ``at``) count.
    """
    session = dataset.session
    if session is None:
        return []
    order, ids = order_and_time(dataset)[0], dataset.pose_ids
    found: list[Suspicion] = []
    firsts = [0, *(np.flatnonzero(np.diff(session)) + 1).tolist(), dataset.n_poses]
    for effect in effects:
        at = effect.target.get("at")
        row = int(np.searchsorted(order, at["order"])) if isinstance(at, dict) else dataset.n_poses
        for begin, end in pairwise(firsts):
            near = NEAR_BOUNDARY * (end - begin)
            late = begin < row < end < dataset.n_poses and end - row <= near
            early = 0 < begin < row < end and row - begin <= near
            if not late and not early:
                continue
            first = end if late else begin
            count = abs(first - row)
            found.append(
                Suspicion(
                    "session",
                    f"pose {ids[first]}",
                    f"'{effect.title}' begins at pose {ids[row]}, {count} {'poses' if count > 1 else 'pose'} {'before' if late else 'after'} the "
                    f"column session of poses.csv changes (at pose {ids[first]}): if both are one change of the set-up, the session changes too "
                    f"{'late' if late else 'early'}; let it change at pose {ids[row]}, and diagnose again",
                )
            )
    return found
