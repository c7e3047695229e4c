"""Motions of the whole arm: a pedestal that tilts under the arm's moving weight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.effects.effect import BaseEffect
from scalar.effects.gravity import AXES, unit_moments
from scalar.poses import Poses
from scalar.robot import Robot
from scalar.se3 import Array


@dataclass(frozen=True, eq=False)
class BaseCompliance(BaseEffect):
    """The base turns about its origin in proportion to the weight's moment: ``w = sum over frames of c . (R_i e) x g / |g|``.

    Attributes:
        frames: From 1: whose first moments of mass act. Two coefficients a frame.
    """

    frames: tuple[int, ...]

    name: ClassVar[str] = "base_compliance"
    sentence: ClassVar[str] = "the pedestal tilts under the arm's moving weight"

    @property
    def target(self) -> dict[str, Any]:
        """Nothing: the base."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """``frame3_x_rad``: tilt at full leverage of a moment along x of frame 3."""
        return [f"frame{f}_{axis}_rad" for f in self.frames for axis in AXES]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.frames))

    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the tilts of unit first moments, about the origin of the base frame."""
        moments, _ = unit_moments(robot, poses.q)
        index = np.array(self.frames) - 1
        w = np.swapaxes(moments[:, index].reshape(len(poses), -1, 3), 1, 2)
        return np.concatenate([w, np.zeros_like(w)], axis=1)

    def to_mapping(self) -> dict[str, Any]:
        """Return the frames."""
        return {"frames": list(self.frames)}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple(int(f) for f in mapping["frames"]))
