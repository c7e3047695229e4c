"""A twist or a length of the table of joints with the wrong sign: alpha typed as +90 degrees where it is -90, or d counted against the axis.

A wrong twist mirrors the axes behind its link, which no single sign or zero of a joint undoes: all of their joints would have to count the other way,
and their offsets d to change sign.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import ALPHA, Alternative, with_robot
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.standard_dh import as_stated
from scalar.units import DEG, MM

LEAST_TWIST = 20 * DEG  # from parallel: a fit finds the sign of a smaller twist by itself
LEAST_LENGTH = 10 * MM  # likewise, of a length


def twist_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which alpha of one link has the other sign; that of a standard table's last row turns the sensor alone."""
    for j, alpha in enumerate(dataset.robot.geometry[ALPHA]):
        if abs(np.sin(alpha)) > np.sin(LEAST_TWIST):
            yield _with_other_sign(dataset, ALPHA, j)


def length_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one length has the other sign; those of a standard table's last row shift the sensor alone."""
    robot = dataset.robot
    for k, kind in enumerate(GEOMETRY):
        if kind not in LENGTHS:
            continue
        for j in np.flatnonzero(np.abs(robot.geometry[k]) > LEAST_LENGTH):
            if kind == "d" and robot.slides[j]:
                continue  # the zero of a travel
            yield _with_other_sign(dataset, k, int(j))


def _with_other_sign(dataset: Dataset, k: int, j: int) -> Alternative:
    """Return the alternative in which parameter ``GEOMETRY[k]`` of joint j (from 0) has the other sign."""
    robot, is_length = dataset.robot, GEOMETRY[k] in LENGTHS
    geometry = robot.geometry.copy()
    geometry[k, j] *= -1.0
    was, now = (_in_words(values[k, j], is_length) for values in (robot.geometry, geometry))
    name = as_stated(f"{GEOMETRY[k]}_{j + 1}", robot)
    return with_robot(
        dataset,
        robot.with_geometry(geometry),
        "length_sign" if is_length else "twist_sign",
        name,
        f"{name} has the wrong sign: it is {was} in the table of joints",
        f"with {now}",
    )


def _in_words(value: float, is_length: bool) -> str:
    return f"{value / MM:.6g} mm" if is_length else f"{value / DEG:.4g} degrees"
