"""Two joints whose zeros are both wrong, as where the offsets of a controller were forgotten: a fit follows one such zero, but not two."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_robot, with_zero_moved
from scalar.estimation.setup.arm.moved_zeros import best_zeros
from scalar.estimation.setup.trial import thinned
from scalar.units import DEG

STARTS = (90 * DEG, 180 * DEG, -90 * DEG)
"""Offsets of controllers are multiples of a quarter turn; a fit finds others near them."""


def two_zeros(dataset: Dataset) -> Iterator[Alternative]:
    """Yield for every two inner joints the alternative in which both have other zeros, those of the best of several quick fits.

    Another zero of the first joint turns the target, and one of the last joint the sensor, which are fitted anyway.
    """
    robot, few = dataset.robot, thinned(dataset)
    moving = [j for j in range(1, robot.n_joints - 1) if np.ptp(dataset.q[:, j]) > 0 and not robot.slides[j]]
    for pair in itertools.combinations(moving, 2):
        zeros = best_zeros(few, pair, itertools.product(STARTS, repeat=2))
        moved = robot
        for joint, zero in zip(pair, zeros, strict=True):
            moved = with_zero_moved(moved, joint, zero)
        where = f"joints {pair[0] + 1} and {pair[1] + 1}"
        found = with_robot(
            dataset, moved, "joint_zero", where, f"the zeros of {where} are off", "with both moved"
        )
        yield replace(found, zeros=tuple((joint + 1, zero) for joint, zero in zip(pair, zeros, strict=True)))
