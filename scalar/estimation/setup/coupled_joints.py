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

PARALLEL = 0.05  # sine of the angle between two axes that count as parallel: a table that was calibrated once may have them some degrees apart


def coupled_joints(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the angle of a joint contains that of the joint before it, or of two parallel ones, with either sign."""
    robot, moving = dataset.robot, np.ptp(dataset.q, axis=0) > 0
    parallel = np.abs(np.sin(robot.geometry[ALPHA])) <= PARALLEL  # to the joint before
    for j in range(1, robot.n_joints):
        if not moving[j - 1 : j + 1].all() or robot.slides[j - 1 : j + 1].any():
            continue
        yield from _with_those_before(dataset, j, [j - 1], from_horizontal=bool(parallel[j]))
        if j > 1 and parallel[j - 1 : j + 1].all() and moving[j - 2] and not robot.slides[j - 2]:
            yield from _with_those_before(dataset, j, [j - 2, j - 1], from_horizontal=True)


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
