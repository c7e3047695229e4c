"""A twist or a length of the table of joints with the wrong sign or a slipped digit: alpha typed as +90 degrees where it is -90, or 60 mm for 600.

A wrong twist mirrors the axes behind its link, which no single sign or zero of a joint undoes: all of their joints would have to count the other way,
and their offsets d to change sign.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import ALPHA, Alternative, with_robot
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.standard_dh import as_stated
from scalar.units import DEG, MM

LEAST_TWIST = 20 * DEG  # from parallel: a fit finds the sign of a smaller twist by itself
LEAST_LENGTH = 10 * MM  # likewise, of a length


def twist_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which alpha of one link has the other sign, and that in which all have it.

    That of a standard table's last row turns the sensor alone.
    """
    twists = np.flatnonzero(np.abs(np.sin(dataset.robot.geometry[ALPHA])) > np.sin(LEAST_TWIST))
    for j in twists:
        yield _with_factor(dataset, ALPHA, int(j), -1.0, "twist_sign")
    if len(twists) > 1:
        yield with_robot(
            dataset,
            with_all_twists_back(dataset.robot),
            "twist_sign",
            "alpha",
            "all twists alpha have the wrong sign in the table of joints",
            "with all of their signs changed",
        )


def with_all_twists_back(robot: Robot) -> Robot:
    """Return the arm whose twists all have the other sign, as the maker of a table may count them."""
    geometry = robot.geometry.copy()
    geometry[ALPHA] *= -1.0
    return robot.with_geometry(geometry)


def length_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one length has the other sign; those of a standard table's last row shift the sensor alone."""
    for k, j in _lengths(dataset.robot):
        yield _with_factor(dataset, k, j, -1.0, "length_sign")


def slipped_digits(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one length is ten times as long or short: 60 typed for 600."""
    for k, j in _lengths(dataset.robot):
        for factor, says in ((10.0, "is ten times too short"), (0.1, "is ten times too long")):
            yield _with_factor(dataset, k, j, factor, "length_digit", says)


def _lengths(robot: Robot) -> Iterator[tuple[int, int]]:
    """Yield row and joint (from 0) in ``Robot.geometry`` of every length that is not short; zeros of travels are none."""
    for k, kind in enumerate(GEOMETRY):
        if kind in LENGTHS:
            for j in np.flatnonzero(np.abs(robot.geometry[k]) > LEAST_LENGTH):
                if not (kind == "d" and robot.slides[j]):
                    yield k, int(j)


def _with_factor(
    dataset: Dataset, k: int, j: int, factor: float, what: str, says: str = "has the wrong sign"
) -> Alternative:
    """Return the alternative in which parameter ``GEOMETRY[k]`` of joint j (from 0) is multiplied by a factor."""
    robot = dataset.robot
    geometry = robot.geometry.copy()
    geometry[k, j] *= factor
    was, now = (_in_words(values[k, j], GEOMETRY[k] in LENGTHS) for values in (robot.geometry, geometry))
    name = as_stated(f"{GEOMETRY[k]}_{j + 1}", robot)
    return with_robot(
        dataset,
        robot.with_geometry(geometry),
        what,
        name,
        f"{name} {says}: it is {was} in the table of joints",
        f"with {now}",
    )


def _in_words(value: float, is_length: bool) -> str:
    return f"{value / MM:.6g} mm" if is_length else f"{value / DEG:.4g} degrees"
