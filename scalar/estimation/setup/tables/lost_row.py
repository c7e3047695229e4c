"""Measurements that belong to the pose before or after the one that they are listed with, over a part of the table: a row was lost or doubled there.

A part of the table that no such row divides fits the nominal arm by itself. Sensor and target are fitted to several parts, and with the best of these
fits every measurement is compared with the pose that it is listed with and with the ones before and after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import distances_under
from scalar.estimation.residuals import Residuals
from scalar.estimation.setup.alternatives import Alternative, readings_of_labels
from scalar.estimation.setup.other_angles import shifted
from scalar.estimation.setup.trial import quick_fit
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from scalar.units import MM

SHIFTS = (0, 1, -1)
"""States of a row: how many rows before it the pose stands that its measurement belongs to."""
LEAST_PART = 15  # poses to which sensor and target are fitted
PARTS = 3  # into which the table is divided: with two changes, one of them at least is whole
BELONGS = 30 * MM
"""A measurement farther from a pose does not belong to it; the errors of a nominal arm are smaller."""
FOR_A_CHANGE = 2.5  # measurements that have to belong to other poses before a row is said to be lost; two may be exchanged rows
MOST_CHANGES = 2  # rows lost or doubled


def lost_rows(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the measurements between two poses, or from a pose on, belong to the poses before or after theirs."""
    for labels_go_along in readings_of_labels(dataset):
        model = _fitted_to_a_part(dataset, labels_go_along)
        if model is not None:
            yield from _under(dataset, model, labels_go_along)


def lost_row_in_words(dataset: Dataset, model: Model, outliers: Sequence[int]) -> str:
    """Return a sentence if poses that contradict the others belong to the rows before or after theirs; empty if they do not.

    Args:
        dataset: Poses in the order of acquisition.
        model: Fitted to the poses that agree.
        outliers: Ids of the poses that contradict them.
    """
    for labels_go_along in readings_of_labels(dataset):
        for alternative in _under(dataset, model, labels_go_along):
            moved = alternative.dataset
            off = distances_under(moved, model) > BELONGS
            if not np.any(off & np.isin(moved.pose_ids, outliers)):
                return f"{alternative.says}: {alternative.remedy}"
    return ""


def _under(dataset: Dataset, model: Model, labels_go_along: bool) -> Iterator[Alternative]:
    """Yield the alternative that the distances of measurements from the poses near theirs make likely by a model; none if each belongs to its own."""
    distances = np.array([_distances(dataset, model, shift, labels_go_along) for shift in SHIFTS])
    shifts = np.array(SHIFTS)[_likely_states(distances)]
    changes = np.flatnonzero(np.diff(shifts)) + 1
    if not 0 < len(changes) <= MOST_CHANGES or len(set(shifts)) != 2:
        return
    where = _where(dataset, shifts, changes)
    shift = int(shifts[shifts != 0][0])
    near = np.unique(np.concatenate([changes - 1, changes]))
    alone = near[distances.min(axis=0)[near] > BELONGS]  # the angles of these measurements were lost
    yield Alternative(
        "lost_row",
        where,
        f"{where}, each measurement belongs to the pose {'before' if shift > 0 else 'after'} the one that it is listed with",
        "with the joint angles moved by one row there",
        f"look for a row that was lost or doubled near pose {dataset.pose_ids[changes[0]]}",
        shifted(dataset, _without(shifts, alone), labels_go_along),
        file="poses.csv",
    )


def _without(shifts: Array, rows: Array) -> Array:
    """Return the shifts ``(N,)`` with those of some rows so large that no angles stand there, so that the rows are left out."""
    changed = shifts.copy()
    changed[rows] = len(shifts)
    return changed


def _where(dataset: Dataset, shifts: Array, changes: Array) -> str:
    """Return which poses are concerned, in words."""
    ids = dataset.pose_ids
    if len(changes) > 1:
        return f"from pose {ids[changes[0]]} to pose {ids[changes[1] - 1]}"
    return f"from pose {ids[changes[0]]} on" if shifts[-1] else f"up to pose {ids[changes[0] - 1]}"


def _fitted_to_a_part(dataset: Dataset, labels_go_along: bool) -> Model | None:
    """Return the nominal arm with sensor and target fitted to the part of the table, in any state, that fits best; None if none fits."""
    best: tuple[float, Model | None] = (BELONGS, None)
    targets = _targets(dataset)
    for shift in SHIFTS:
        moved = _all_shifted(dataset, shift, labels_go_along)
        parts = PARTS if moved.n_poses >= PARTS * LEAST_PART else PARTS - 1
        for rows in np.array_split(np.arange(moved.n_poses), parts):
            part = moved.subset(rows)
            if len(rows) < LEAST_PART or _targets(part) != targets:
                continue
            nominal, model = quick_fit(part)
            best = min(best, (nominal.of_all, model), key=lambda entry: entry[0])
    return best[1]


def _all_shifted(dataset: Dataset, shift: int, labels_go_along: bool) -> Dataset:
    return shifted(dataset, np.full(dataset.n_poses, shift), labels_go_along)


def _targets(dataset: Dataset) -> list[str]:
    """Return the names of the coordinates of all targets that are measured."""
    return measure(dataset).initial_target(dataset).parameter_names


def _distances(dataset: Dataset, model: Model, shift: int, labels_go_along: bool) -> Array:
    """Return how far each measurement is from the pose ``shift`` rows before it ``(N,)`` [m]; infinity where there is no such pose."""
    found = np.full(dataset.n_poses, np.inf)
    rows = np.arange(dataset.n_poses) - shift
    there = (rows >= 0) & (rows < dataset.n_poses)
    try:
        moved = _all_shifted(dataset, shift, labels_go_along)
        found[there] = Residuals.of(moved, model, measure(moved)).pose_distances(model)
    except (ScalarError, ValueError, np.linalg.LinAlgError):
        pass
    return found


def _likely_states(distances: Array) -> Array:
    """Return the likeliest sequence of states ``(N,)``, by Viterbi's algorithm; a change of the state costs as much as some measurements.

    Args:
        distances: ``(S, N)`` [m], of each measurement in each of S states.
    """
    cost = np.minimum(distances / BELONGS, 1.0)
    S, N = cost.shape
    total, came_from = cost[:, 0], np.zeros((S, N), dtype=int)
    for i in range(1, N):
        reached = total[:, None] + FOR_A_CHANGE * (1.0 - np.eye(S))
        came_from[:, i] = np.argmin(reached, axis=0)
        total = reached.min(axis=0) + cost[:, i]
    states = np.empty(N, dtype=int)
    states[-1] = int(np.argmin(total))
    for i in range(N - 1, 0, -1):
        states[i - 1] = came_from[states[i], i]
    return states
