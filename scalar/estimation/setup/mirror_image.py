"""The joints of an arm that all count the other way in its mirror image.

Most arms have a plane of symmetry: their mirror image is the same arm with some of its joints counting the other way (often joints 1, 4 and 6).
Measurements in a left-handed frame and wrong signs of all these joints then look the same.
"""

from __future__ import annotations

import itertools

import numpy as np

from scalar.effects.title import joints_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, nearest_rotation

_SAMPLES, _SEED = 20, 0
_MIRROR = np.array([1.0, -1.0, 1.0])
# Points of the flange [m] in two planes through its axis; one of these is the plane of symmetry where there is any.
_ON_FLANGE = ((0.1, 0.0, 0.1), (0.0, 0.1, 0.1))
_SAME = 1e-6  # of the spread of the points: by how much mirror images may differ through rounding


def mirrored_joints(robot: Robot) -> tuple[int, ...]:
    """Return the joints, from 1, that count the other way in the mirror image of an arm; none if its mirror image is another arm.

    Args:
        robot: The arm.
    """
    n = robot.n_joints
    q = np.random.default_rng(_SEED).uniform(-1.0, 1.0, (_SAMPLES, n))
    for point in _ON_FLANGE:
        image = _points(robot, q, point) * _MIRROR
        for size in range(1, n + 1):
            for joints in itertools.combinations(range(n), size):
                signs = np.ones(n)
                signs[list(joints)] = -1.0
                if _are_the_same(image, _points(robot, signs * q, point)):
                    return tuple(j + 1 for j in joints)
    return ()


def or_wrong_signs(robot: Robot) -> str:
    """Return what else looks like a left-handed frame, to be added to a remedy; empty if nothing does."""
    joints = mirrored_joints(robot)
    if not joints:
        return ""
    return f"; wrong signs of all of {joints_in_words(joints)} look the same: jog one of them and see which way it turns"


def _points(robot: Robot, q: Array, point: tuple[float, float, float]) -> Array:
    """Return where a point of the flange is at joint positions ``(N, 3)`` [m]."""
    return robot.flange(q)[:, :3] @ np.array([*point, 1.0])


def _are_the_same(points: Array, others: Array) -> bool:
    """Return whether a rotation and a shift take points ``(N, 3)`` to others."""
    a, b = points - points.mean(axis=0), others - others.mean(axis=0)
    R = nearest_rotation(b.T @ a)
    return bool(np.linalg.norm(b - a @ R.T) < _SAME * np.linalg.norm(b))
