"""How well a deflection follows the weight of an arm with typical masses.

The masses of an arm are unknown, so what gives way under its weight is fitted with first moments of mass that may have any size and
direction in each link. Sums of sinusoids of the joints' angles, and of their sums, are then compliances too: a spring, a hose or a floor that
settles resembles one, with masses beside or behind the links. In an arm as it is built, the links have their masses between their joints, and
bear those of the links after them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scalar.effects.gravity import typical_moment, typical_torque
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

LOADED = 0.2  # chosen: a joint whose typical torque varies by a smaller share of the largest, such as a wrist's, may bear mainly an unknown tool
LARGE = 0.5  # chosen: a joint that is deflected by a smaller share of the largest deflection may bear mainly the unknown masses of a wrist


def joints_along_weight(robot: Robot, q: Array, deflections: Mapping[int, Array]) -> float | None:
    """Return how well deflections of joints follow the torques of an arm with 1 kg at the end of each link: 1 exactly, 0 not at all, -1 inversely.

    Args:
        robot: The nominal arm.
        q: ``(N, n)`` [rad, m].
        deflections: Of each joint that gives way, from 1, ``(N,)`` [rad].

    Returns:
        The cosine between the two as they vary over the poses, of the joint that follows its torque least, among those that are loaded and deflected
        most; None if there is none.
    """
    torques = {joint: typical_torque(robot, q, joint) for joint in robot.turning}
    most_torque = max(np.std(torque) for torque in torques.values())
    most_deflection = max(np.std(deflection) for deflection in deflections.values())
    found = [
        cosine(deflection[:, None], torques[joint][:, None])
        for joint, deflection in deflections.items()
        if np.std(torques[joint]) >= LOADED * most_torque and np.std(deflection) >= LARGE * most_deflection
    ]
    return min((each for each in found if each is not None), default=None)


def base_along_weight(robot: Robot, q: Array, joint: int, tilts: Array) -> float | None:
    """Return how well tilts of a base follow the moment of an arm with 1 kg at the end of each link, as ``joints_along_weight`` does.

    Args:
        robot: The nominal arm.
        q: ``(N, n)`` [rad, m].
        joint: The first joint whose link loads the base, from 1.
        tilts: Rotations of the base ``(N, 3)`` [rad], in its frame.
    """
    return cosine(tilts, typical_moment(robot, robot.frames(q), joint))


def cosine(a: Array, b: Array) -> float | None:
    """Return the cosine between two arrays ``(N, k)`` less their means over the poses; None if one of them does not vary."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(np.sum(a * b)) / size if size > 0.0 else None
