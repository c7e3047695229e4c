"""Whether the coefficients of an effect are sizes that its cause has in real workcells."""

from __future__ import annotations

import numpy as np

from scalar.data.poses import Poses
from scalar.effects import Effect
from scalar.geometry.robot import Robot


def is_implausible(effect: Effect, robot: Robot, poses: Poses, most: float) -> bool:
    """Return whether an effect is impossible, or far beyond its size in real workcells, as a range scale of -1 is.

    Args:
        effect: The effect with its coefficients.
        robot: The arm.
        poses: The measured poses.
        most: Largest plausible coefficient [standard deviations of ``Effect.plausible_std``].
    """
    return bool(np.any(np.abs(effect.coefficients) > most * effect.plausible_std)) or effect.is_impossible(
        robot, poses
    )
