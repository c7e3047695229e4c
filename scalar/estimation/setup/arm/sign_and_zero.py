"""A joint that has another zero, or counts the other way as well: a controller's angle taken without its offset and its sign.

Joint 2 of many arms reads -90 degrees where the table of joints has zero, and counts downwards. Neither its sign nor its zero alone explains
the data.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import (
    CORRECT_JOINT,
    Alternative,
    with_robot,
    with_sign_changed,
    with_zero_moved,
)
from scalar.estimation.setup.arm.moved_zeros import best_zeros
from scalar.estimation.setup.trial import thinned
from scalar.units import DEG

STEP = 60 * DEG  # between the zeros from which a fit of the zero starts: from half of it away, it converges
_STARTS = tuple((k * STEP,) for k in range(1, round(2 * np.pi / STEP)))


def fitted_zeros(dataset: Dataset) -> Iterator[Alternative]:
    """Yield for every joint that turns the alternative in which its zero is where a quick fit has it.

    Zeros are tried in steps first, without a fit of them. If one lies midway between two steps, a large arm is then still decimetres off.
    """
    few = thinned(dataset)
    for joint in _turning(dataset):
        (zero,) = best_zeros(few, [joint], _STARTS)
        found = with_robot(
            dataset,
            with_zero_moved(dataset.robot, joint, zero),
            "joint_zero",
            f"joint {joint + 1}",
            f"the zero of joint {joint + 1} is off",
            "with its zero moved",
            CORRECT_JOINT,
        )
        yield replace(found, zeros=((joint + 1, zero),))


def signs_and_zeros(dataset: Dataset) -> Iterator[Alternative]:
    """Yield for every joint that turns the alternative in which it counts the other way, its zero where a quick fit has it."""
    few = thinned(dataset)
    for joint in _turning(dataset):
        robot = with_sign_changed(dataset.robot, joint)
        (zero,) = best_zeros(replace(few, robot=robot), [joint], _STARTS)
        found = with_robot(
            dataset,
            with_zero_moved(robot, joint, zero),
            "sign_and_zero",
            f"joint {joint + 1}",
            f"joint {joint + 1} counts the other way and its zero is off",
            "with both changed",
            CORRECT_JOINT,
        )
        yield replace(found, zeros=((joint + 1, zero),), counts_back=True)


def _turning(dataset: Dataset) -> list[int]:
    """Return the joints (from 0) that turn, and do so in some pose."""
    moving = np.flatnonzero(np.ptp(dataset.q, axis=0) > 0)
    return [int(joint) for joint in moving if joint not in dataset.robot.prismatic]
