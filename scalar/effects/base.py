"""Motions of the whole arm: a pedestal that tilts under the arm's moving weight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import BaseEffect
from scalar.effects.gravity import AXES, unit_moments
from scalar.geometry.planes import tangent_basis
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class BaseCompliance(BaseEffect):
    """The base turns about its origin under the weight's moment, more easily about one horizontal axis than about the other.

    ``w = sum over frames of C_i (R_i e) x g / |g|``: tilt about each of two horizontal axes by the moment about it.

    Attributes:
        frames: From 1: whose first moments of mass act.
        alike: Whether it gives way alike about every horizontal axis: two coefficients a frame, one for each component of the
            first moment. Else four, each component tilting about each of two axes.
    """

    frames: tuple[int, ...]
    alike: bool = False

    name: ClassVar[str] = "base_compliance"
    sentence: ClassVar[str] = "the pedestal tilts under the arm's moving weight"

    @property
    def target(self) -> dict[str, Any]:
        """Nothing: the base."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """``frame3_x_rad``, ``tilt_u_frame3_x_rad``: tilt (about u) at full leverage of a first moment along x of frame 3."""
        if self.alike:
            return [f"frame{f}_{axis}_rad" for f in self.frames for axis in AXES]
        return [
            f"tilt_{tilt}_frame{f}_{axis}_rad" for f in self.frames for axis in AXES for tilt in ("u", "v")
        ]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * ((2 if self.alike else 4) * len(self.frames))

    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the tilts of unit first moments, about the origin of the base frame."""
        moments, _ = unit_moments(robot, poses.q)
        index = np.array(self.frames) - 1
        down = robot.gravity / max(float(np.linalg.norm(robot.gravity)), 1e-12)
        across = tangent_basis(down[None])[0]
        if self.alike:
            w = np.swapaxes(moments[:, index].reshape(len(poses), -1, 3), 1, 2)
            return np.concatenate([w, np.zeros_like(w)], axis=1)
        by_axis = np.einsum("nfax,tx->nfat", moments[:, index], across)
        w = (by_axis[..., None] * across).reshape(len(poses), -1, 3)
        w = np.swapaxes(w, 1, 2)
        return np.concatenate([w, np.zeros_like(w)], axis=1)

    def to_mapping(self) -> dict[str, Any]:
        """Return the frames."""
        return {"frames": list(self.frames), "alike": self.alike}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple(int(f) for f in mapping["frames"]), bool(mapping["alike"]))
