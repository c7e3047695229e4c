"""A twist of the table of joints with the wrong sign: alpha typed as +90 degrees where it is -90.

The axes behind such a link are mirrored, which no single sign or zero of a joint undoes: all of their joints would have to count the other way, and
their offsets d to change sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import ALPHA, CORRECT_TABLE, Alternative
from scalar.geometry.standard_dh import as_stated
from scalar.units import DEG

LEAST_TWIST = 20 * DEG  # from parallel: a fit finds the sign of a smaller twist by itself


def twists(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which alpha of one link has the other sign; that of a standard table's last row turns the sensor alone."""
    robot = dataset.robot
    for j, alpha in enumerate(robot.geometry[ALPHA]):
        if abs(np.sin(alpha)) < np.sin(LEAST_TWIST):
            continue
        geometry = robot.geometry.copy()
        geometry[ALPHA, j] = -alpha
        name = as_stated(f"alpha_{j + 1}", robot)
        yield Alternative(
            "twist_sign",
            name,
            f"{name} has the wrong sign: it is {alpha / DEG:.4g} degrees in the table of joints",
            f"with {-alpha / DEG:.4g} degrees",
            CORRECT_TABLE,
            replace(dataset, robot=robot.with_geometry(geometry)),
            corrects_robot=True,
        )
