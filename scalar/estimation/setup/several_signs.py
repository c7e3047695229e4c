"""Two or three joints at once that count the other way, as with a controller that counts some of its axes against the convention of the table.

They are tried after all single alternatives. Some sets of signs cannot be distinguished from a smaller set with another zero or another place of
the sensor; ``scalar.estimation.setup.suspicion`` ranks them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import CORRECT_SIGNS, Alternative, with_sign_changed

MOST_SIGNS = 3


def several_signs(dataset: Dataset, count: int) -> Iterator[Alternative]:
    """Yield every alternative in which ``count`` joints that move count the other way."""
    moving = [j for j in range(dataset.robot.n_joints) if np.ptp(dataset.q[:, j]) > 0]
    for joints in itertools.combinations(moving, count):
        robot = dataset.robot
        for joint in joints:
            robot = with_sign_changed(robot, joint)
        names = [str(joint + 1) for joint in joints]
        where = f"joints {', '.join(names[:-1])} and {names[-1]}"
        yield Alternative(
            "joint_sign",
            where,
            f"{where} count the other way",
            "with their signs changed",
            CORRECT_SIGNS,
            replace(dataset, robot=robot),
            corrects_robot=True,
        )
