"""A joint that counts the other way and has another zero: a controller's angle taken without its sign and its offset.

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
from scalar.estimation.setup.moved_zeros import best_zeros
from scalar.estimation.setup.trial import thinned
from scalar.units import DEG

STEP = 60 * DEG  # between the zeros from which a fit of the zero starts: from half of it away, it converges


def signs_and_zeros(dataset: Dataset) -> Iterator[Alternative]:
    """Yield for every joint that turns the alternative in which it counts the other way, its zero where a quick fit has it."""
    few = thinned(dataset)
    for j in np.flatnonzero(np.ptp(dataset.q, axis=0) > 0):
        joint = int(j)
        if joint in dataset.robot.prismatic:
            continue
        robot = with_sign_changed(dataset.robot, joint)
        starts = [(k * STEP,) for k in range(1, round(2 * np.pi / STEP))]
        (zero,) = best_zeros(replace(few, robot=robot), [joint], starts)
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
