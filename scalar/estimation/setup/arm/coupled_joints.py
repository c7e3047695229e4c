"""Angles that contain those of other joints, as some controllers show them.

The controllers of FANUC count joint 3 from the horizontal, with the angle of the parallel joint before it, and so do those of palletisers whose
linkage keeps the forearm parallel; after three parallel joints the last one may contain the two before it. In a wrist whose drives run through one
another, the angle of a motor contains that of the joint before. DH parameters describe the angle between two links, so such angles fit no table of
joints until those of the others are subtracted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import ALPHA, Alternative
from scalar.geometry.robot import BoolArray

PARALLEL = 0.05  # sine of the angle between two axes that count as parallel: a table that was calibrated once may have them some degrees apart


def coupled_joints(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the angle of a joint contains that of the parallel joint before it, with either sign."""
    parallel = _parallel(dataset)
    for j in _turn_after_another(dataset):
        if parallel[j]:
            yield from _with_those_before(dataset, j, [j - 1], from_horizontal=True)


def coupled_drives(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the angle of a joint contains that of the joint before it, not parallel, or of two parallel ones before it."""
    parallel, after_another = _parallel(dataset), _turn_after_another(dataset)
    for j in after_another:
        if not parallel[j]:
            yield from _with_those_before(dataset, j, [j - 1], from_horizontal=False)
        elif parallel[j - 1] and j - 1 in after_another:
            yield from _with_those_before(dataset, j, [j - 2, j - 1], from_horizontal=True)


def _parallel(dataset: Dataset) -> BoolArray:
    """Return which joints ``(n,)`` are parallel to the one before them."""
    return np.abs(np.sin(dataset.robot.geometry[ALPHA])) <= PARALLEL


def _turn_after_another(dataset: Dataset) -> list[int]:
    """Return the joints, from 0, that turn and move as the one before them does."""
    turns = (np.ptp(dataset.q, axis=0) > 0) & ~dataset.robot.slides
    return [j for j in range(1, dataset.robot.n_joints) if turns[j - 1 : j + 1].all()]


def _with_those_before(
    dataset: Dataset, j: int, before: list[int], *, from_horizontal: bool
) -> Iterator[Alternative]:
    """Yield the alternatives in which the angle of joint ``j`` is the sum with those of the joints ``before`` it (all from 0), or less them."""
    this, others = f"q{j + 1}", [f"q{i + 1}" for i in before]
    names = " and ".join(f"{i + 1}" for i in before)
    joints = f"joint {names}" if len(before) == 1 else f"joints {names}"
    for sign, contains, link, remedy in ((1, "contains", "plus", "minus"), (-1, "lacks", "minus", "plus")):
        subtracted = " ".join(f"{remedy} {other}" for other in others)
        where = (
            f" (where 'scalar import' made it: '{remedy}' in the mapping of {this}, if {others[0]} and {this} have the same sign there)"
            if len(before) == 1
            else ""
        )
        counted = (
            f"joint {j + 1} is counted from the horizontal, as its angle {link} that of {joints}"
            if from_horizontal
            else f"the drives of joints {j} and {j + 1} are coupled, and the angle is that of the motor"
        )
        yield Alternative(
            "coupled_joints",
            f"joints {before[0] + 1} and {j + 1}",
            f"{this} of poses.csv {contains} {' and '.join(others)}: {counted}",
            f"with {this} {subtracted} in place of {this}",
            f"write {this} {subtracted} into the column {this} of poses.csv{where}, and into every table for this calibration",
            replace(
                dataset,
                poses=dataset.poses.assign(
                    **{this: dataset.q[:, j] - sign * dataset.q[:, before].sum(axis=1)}
                ),
            ),
            file="poses.csv",
        )
