"""Two targets on one flange whose names are exchanged in some rows: the tracker measured one of them and wrote the name of the other.

Seen from the flange, each of the two then sits where the other one sits. That distinguishes the error from a reflector that was put elsewhere, and
from a pose whose joint angles are wrong.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import distances_under
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

FALLS_TO = 0.1  # of the distance as it is written: with the names exchanged a pose has to lie nearer than that to where a fit to the others has it
LEAST_NEAR = (
    3 * MM
)  # and within the larger of this and ten times the usual distance: effects of an arm make no pose err farther
TIMES_USUAL = 10.0


def with_names_exchanged(dataset: Dataset, rows: Array, first: str, second: str) -> Dataset:
    """Return the dataset with the names of two targets exchanged in some poses.

    Args:
        dataset: With several targets.
        rows: ``(N,)`` bool, the poses in which they are exchanged.
        first: Name of one target.
        second: Name of the other.
    """
    a, b = dataset.targets.index(first), dataset.targets.index(second)
    index = dataset.point_columns["target"]
    there = np.repeat(rows, np.diff(dataset.starts))
    exchanged = np.where(index == a, b, np.where(index == b, a, index))
    columns = {**dataset.point_columns, "target": np.where(there, exchanged, index)}
    return replace(dataset, point_columns=columns)


def names_exchanged_in_words(dataset: Dataset, model: Model, rows: Array, distances: Array) -> dict[int, str]:
    """Return for each pose that exchanged names explain what is wrong with it, and what to do, as a sentence that begins with the pose.

    Args:
        dataset: What was measured.
        model: As fitted to the other poses.
        rows: ``(N,)`` bool, the poses that contradict the others.
        distances: ``(N,)`` [m], how far every pose lies from where the model has it.
    """
    if len(dataset.targets) < 2 or "target" not in dataset.point_columns or not rows.any():
        return {}
    near = max(LEAST_NEAR, TIMES_USUAL * float(np.median(distances[~rows])))
    table = kind_of(dataset).format.measured_in
    found: dict[int, tuple[float, str]] = {}
    for first, second in itertools.combinations(dataset.targets, 2):
        then = distances_under(with_names_exchanged(dataset, rows, first, second), model)
        for row in np.flatnonzero(rows & (then < near) & (then < FALLS_TO * distances)):
            words = (
                f"the names '{first}' and '{second}' of its targets are exchanged: with the two exchanged it lies {then[row] / MM:.2g} mm from where "
                f"a fit to the others has it, and as it is written {distances[row] / MM:.3g} mm; exchange them in the rows of this pose in {table}"
            )
            found[int(row)] = min(found.get(int(row), (np.inf, "")), (float(then[row]), words))
    return {row: f"in pose {dataset.pose_ids[row]} {words}" for row, (_, words) in found.items()}
