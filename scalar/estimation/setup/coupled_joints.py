"""Angles that some controllers show from the horizontal: the angle of a joint then contains that of the parallel joint before it.

The controllers of FANUC count joint 3 so, and those of palletisers whose linkage keeps the forearm parallel. DH parameters describe the angle between
two links, so such angles fit no table of joints until that of the joint before is subtracted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import ALPHA, Alternative

PARALLEL = 0.05  # sine of the angle between two axes that count as parallel: a table that was calibrated once may have them some degrees apart


def coupled_joints(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which the angle of a joint contains that of the parallel joint before it, with one sign or the other."""
    robot = dataset.robot
    for j in range(1, robot.n_joints):
        moving = min(np.ptp(dataset.q[:, j - 1]), np.ptp(dataset.q[:, j])) > 0
        if (
            not moving
            or robot.slides[j - 1 : j + 1].any()
            or abs(np.sin(robot.geometry[ALPHA, j])) > PARALLEL
        ):
            continue
        this, last = f"q{j + 1}", f"q{j}"
        for sign, contains, link, remedy in (
            (1, f"contains {last}", "plus", "minus"),
            (-1, f"lacks {last}", "minus", "plus"),
        ):
            where = f" (where 'scalar import' made it: '{remedy}' in the mapping of {this}, if {last} and {this} have the same sign there)"
            angles = dataset.q[:, j] - sign * dataset.q[:, j - 1]
            yield Alternative(
                "coupled_joints",
                f"joints {j} and {j + 1}",
                f"{this} of poses.csv {contains}: joint {j + 1} is counted from the horizontal, as its angle {link} that of joint {j}",
                f"with {this} {remedy} {last} in place of {this}",
                f"write {this} {remedy} {last} into the column {this} of poses.csv{where}, and into every table for this calibration",
                replace(dataset, poses=dataset.poses.assign(**{this: angles})),
                file="poses.csv",
            )
