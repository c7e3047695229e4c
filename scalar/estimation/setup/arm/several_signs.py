"""Two joints or more at once that count the other way, or all of them, as a controller may count its axes against the convention of the table.

They are tried after all single alternatives, and more than three at once only where nothing else explains the data. Some sets of signs cannot be
distinguished from a smaller set with another zero or another place of the sensor; ``scalar.estimation.setup.suspicion`` ranks them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import CORRECT_SIGNS, Alternative, with_sign_changed

MOST_SIGNS = 3
"""Most signs at once that are tried although a smaller set explains the data, with sensor or planes far from their stated places."""


def several_signs(dataset: Dataset, count: int) -> Iterator[Alternative]:
    """Yield every alternative in which ``count`` joints that move count the other way."""
    for joints in itertools.combinations(_moving(dataset), count):
        names = [str(joint + 1) for joint in joints]
        yield _counted_back(dataset, joints, f"joints {', '.join(names[:-1])} and {names[-1]}")


def many_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which more than ``MOST_SIGNS`` joints that move count the other way, those with fewest joints first."""
    for count in range(MOST_SIGNS + 1, len(_moving(dataset))):
        yield from several_signs(dataset, count)
    yield from all_signs(dataset)


def all_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which all joints that move count the other way, if they are more than ``MOST_SIGNS``."""
    joints = _moving(dataset)
    if len(joints) > MOST_SIGNS:
        every = len(joints) == dataset.robot.n_joints
        yield _counted_back(dataset, joints, "all joints" if every else "all joints that move")


def _moving(dataset: Dataset) -> tuple[int, ...]:
    """Return the joints (from 0) that do not stand still."""
    return tuple(j for j in range(dataset.robot.n_joints) if np.ptp(dataset.q[:, j]) > 0)


def _counted_back(dataset: Dataset, joints: tuple[int, ...], where: str) -> Alternative:
    """Return the alternative in which the signs of these joints (from 0), called ``where`` in sentences, are changed."""
    robot = dataset.robot
    for joint in joints:
        robot = with_sign_changed(robot, joint)
    return Alternative(
        "joint_sign",
        where,
        f"{where} count the other way",
        "with their signs changed",
        CORRECT_SIGNS,
        replace(dataset, robot=robot),
        corrects_robot=True,
    )
