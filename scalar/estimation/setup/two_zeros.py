"""Two joints whose zeros are both wrong, as where the offsets of a controller were forgotten: a fit follows one such zero, but not two."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import CORRECT_TABLE, THETA, Alternative, with_zero_moved
from scalar.estimation.setup.trial import quick_fit, thinned
from scalar.units import DEG

STARTS = (
    90 * DEG,
    180 * DEG,
    -90 * DEG,
)  # offsets of controllers are multiples of a quarter turn; a fit finds others near them


def two_zeros(dataset: Dataset) -> Iterator[Alternative]:
    """Yield for every two inner joints the alternative in which both have other zeros, those of the best of several quick fits.

    Another zero of the first joint turns the target, and one of the last joint the sensor, which are fitted anyway.
    """
    robot, few = dataset.robot, thinned(dataset)
    moving = [j for j in range(1, robot.n_joints - 1) if np.ptp(dataset.q[:, j]) > 0 and not robot.slides[j]]
    for pair in itertools.combinations(moving, 2):
        zeros = _zeros_found(few, pair)
        moved = robot
        for joint, zero in zip(pair, zeros, strict=True):
            moved = with_zero_moved(moved, joint, zero)
        where = f"joints {pair[0] + 1} and {pair[1] + 1}"
        yield Alternative(
            "joint_zero",
            where,
            f"the zeros of {where} are off",
            "with both moved",
            CORRECT_TABLE,
            replace(dataset, robot=moved),
            corrects_robot=True,
            zeros=tuple((joint + 1, zero) for joint, zero in zip(pair, zeros, strict=True)),
        )


def _zeros_found(dataset: Dataset, pair: tuple[int, int]) -> tuple[float, ...]:
    """Return what has to be added to theta of two joints (from 0) [rad], by the best of several quick fits."""
    found: list[tuple[float, tuple[float, ...]]] = []
    for starts in itertools.product(STARTS, repeat=2):
        robot = dataset.robot
        for joint, start in zip(pair, starts, strict=True):
            robot = with_zero_moved(robot, joint, start)
        look, model = quick_fit(replace(dataset, robot=robot), pair)
        fitted = (robot if model is None else model.robot).geometry - dataset.robot.geometry
        found.append((look.rms, tuple(float(fitted[THETA, joint]) for joint in pair)))
    return min(found)[1]
