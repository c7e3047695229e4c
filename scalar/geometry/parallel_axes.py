"""Which successive joint axes of a chain are nearly parallel, where four Denavit-Hartenberg parameters are badly conditioned.

Between parallel axes, d of one joint can be exchanged for d of the next, and no parameter describes a small tilt about y. Hayati's beta
is that parameter (Hayati and Mirmirani, 1985).
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array

NEAR_PARALLEL = 0.1
"""Sine of the angle between two axes below which they count as nearly parallel: about 6 degrees."""
_ALPHA, _BETA = GEOMETRY.index("alpha"), GEOMETRY.index("beta")


def near_parallel(robot: Robot) -> Array:
    """Return for each joint whether its axis is nearly parallel to the one before, ``(n,)`` bool; False for the first."""
    near = np.abs(np.sin(robot.geometry[_ALPHA])) < NEAR_PARALLEL
    near[0] = False
    return near


def near_parallel_joints(robot: Robot) -> list[int]:
    """Return the joints, counted from 1, whose axis is nearly parallel to the one before: where Hayati's beta belongs."""
    return [int(i) + 1 for i in np.flatnonzero(near_parallel(robot))]


def with_parallel_axes(robot: Robot) -> Robot:
    """Return the robot with nearly parallel successive axes made exactly parallel: alpha the nearest multiple of pi, beta 0."""
    geometry = robot.geometry.copy()
    near = near_parallel(robot)
    geometry[_ALPHA] = np.where(near, np.pi * np.round(geometry[_ALPHA] / np.pi), geometry[_ALPHA])
    geometry[_BETA] = np.where(near, 0.0, geometry[_BETA])
    return robot.with_geometry(geometry)
