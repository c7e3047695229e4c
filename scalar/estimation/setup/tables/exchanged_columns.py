"""Columns that are exchanged, or count the other way: of one target among several, and of all positions beside orientations.

The distances between targets on one flange are the same in all poses. If the columns of one target alone are exchanged, these distances change from
pose to pose, and the right order of the columns makes them constant. That holds in any frame and for any arm, so no fit is needed to find it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

FALLS_TO = 0.2  # ratio of the scatter of the distances after and before: with a larger one, the columns are not what is wrong
LEAST_SCATTER = 3 * MM  # smaller changes of the distances have other causes
LEAST_POSES = 5  # at which both targets were measured
_AXES = "xyz"


def exchanged_columns(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which two columns of one target are exchanged, or one counts the other way.

    Only those are yielded with which its distances to the other targets are constant.
    """
    if len(dataset.targets) < 2 or "target" not in dataset.point_columns:
        return
    index = dataset.point_columns["target"].astype(int)
    pose = dataset.pose_of_point
    places = np.full((len(dataset.targets), dataset.n_poses, 3), np.nan)
    places[index, pose] = dataset.points
    file = kind_of(dataset).format.measured_in
    for k, name in enumerate(dataset.targets):
        others = np.delete(places, k, axis=0)
        before = _scatter(places[k], others)
        if not before > LEAST_SCATTER:
            continue
        for says, changed, matrix in _changes():
            if _scatter(places[k] @ matrix.T, others) > FALLS_TO * before:
                continue
            points = dataset.points.copy()
            points[index == k] = points[index == k] @ matrix.T
            yield Alternative(
                "exchanged_columns",
                f"target {name}",
                f"{says} in the rows of target '{name}' in {file}",
                changed,
                f"correct these columns of {file}, for this target alone",
                replace(dataset, points=points),
                file=file,
            )


def exchanged_beside_orientations(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which two columns of all positions are exchanged, or one counts the other way, where orientations are measured.

    Positions alone do not tell these from one another, since the frame of the tracker is unknown; orientations are in the same frame.
    """
    if "rx" not in dataset.point_columns:
        return
    file = kind_of(dataset).format.measured_in
    for says, changed, matrix in _changes():
        yield Alternative(
            "exchanged_columns",
            file,
            f"{says} in {file}, and the orientations beside are right",
            changed,
            f"correct the positions in {file}; where 'scalar import' made it, correct their columns in the mapping, and import again",
            replace(dataset, points=dataset.points @ matrix.T),
        )


def _changes() -> Iterator[tuple[str, str, Array]]:
    """Yield what is wrong, what was done to correct it, and the matrix ``(3, 3)`` that does so."""
    for a, b in itertools.combinations(range(3), 2):
        order = [b if i == a else a if i == b else i for i in range(3)]
        yield (
            f"the columns {_AXES[a]} and {_AXES[b]} are exchanged",
            "with the two exchanged",
            np.eye(3)[order],
        )
    for a in range(3):
        signs = np.where(np.arange(3) == a, -1.0, 1.0)
        yield f"the column {_AXES[a]} counts the other way", "with its sign changed", np.diag(signs)


def _scatter(place: Array, others: Array) -> float:
    """Return how much the distances of a target ``(N, 3)`` [m] to others ``(T, N, 3)`` change from pose to pose [m], the median of the others."""
    scatters = []
    for other in others:
        distance = np.linalg.norm(place - other, axis=1)
        distance = distance[np.isfinite(distance)]
        if len(distance) >= LEAST_POSES:
            scatters.append(float(np.median(np.abs(distance - np.median(distance)))))
    return float(np.median(scatters)) if scatters else np.nan
