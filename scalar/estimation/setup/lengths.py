"""A length of the table of joints with the wrong sign: an offset d counted against the axis, or a length a typed as negative."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import CORRECT_TABLE, Alternative
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.standard_dh import as_stated
from scalar.units import MM

LEAST_LENGTH = 10 * MM  # a fit finds the sign of a shorter one by itself


def length_signs(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one length has the other sign; those of a standard table's last row shift the sensor alone."""
    robot = dataset.robot
    for k, kind in enumerate(GEOMETRY):
        if kind not in LENGTHS:
            continue
        for j in np.flatnonzero(np.abs(robot.geometry[k]) > LEAST_LENGTH):
            if kind == "d" and robot.slides[j]:
                continue  # the zero of a travel
            length = float(robot.geometry[k, j])
            geometry = robot.geometry.copy()
            geometry[k, j] = -length
            name = as_stated(f"{kind}_{j + 1}", robot)
            yield Alternative(
                "length_sign",
                name,
                f"{name} has the wrong sign: it is {length / MM:.6g} mm in the table of joints",
                f"with {-length / MM:.6g} mm",
                CORRECT_TABLE,
                replace(dataset, robot=robot.with_geometry(geometry)),
                corrects_robot=True,
            )
