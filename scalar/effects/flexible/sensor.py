"""The sensor's pose on the flange that errs with the direction of gravity, or drifts with a column."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.polynomial import legendre

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import GRAVITY, Variable
from scalar.effects.places import SensorEffect
from scalar.effects.wording import columns_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

DRIFT_DEGREE = 4  # degree of the polynomials in the column


class MovedSensor(Unattributed, SensorEffect):
    """The sensor's pose on the flange errs by shifts, and by turns where they are observable, each times some functions of the pose.

    Subclasses are dataclasses with the fields ``variable`` and ``turns``.
    """

    variable: Variable
    turns: bool

    @property
    def functions(self) -> list[str]:
        """Return the names of the functions."""
        raise NotImplementedError

    def profile(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions ``(N, k)``, dimensionless."""
        raise NotImplementedError

    @property
    def depends_on(self) -> list[str]:
        """Return the column, or the direction of gravity."""
        return [self.variable.name]

    @property
    def described_as(self) -> str:
        """Return that what is measured moves on the flange, and along what."""
        return f"a motion of what sits on the flange with {columns_in_words(self.depends_on)}"

    @property
    def coefficient_names(self) -> list[str]:
        """Every function for every component of the motion."""
        components = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")[: 6 if self.turns else 3]
        return [f"{f}_{c}" for f in self.functions for c in components]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return (["m"] * 3 + (["rad"] * 3 if self.turns else [])) * len(self.functions)

    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the unit shifts, and rotations if they are observable, times each function."""
        unit = np.zeros((6, 6 if self.turns else 3))
        unit[3:, :3] = np.eye(3)
        if self.turns:
            unit[:3, 3:] = np.eye(3)
        profile = self.profile(robot, poses)
        return (profile[:, None, :, None] * unit[None, :, None, :]).reshape(len(poses), 6, -1)

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that every campaign mounts the sensor anew."""
        return "the sensor is mounted anew for every campaign"


@dataclass(frozen=True, eq=False)
class UnattributedSensor(MovedSensor):
    """The sensor's pose on the flange errs with the direction of gravity, or drifts with a column."""

    variable: Variable
    turns: bool = True

    place: ClassVar[str] = "sensor"

    @property
    def key(self) -> str:
        """Name and variable."""
        return f"{NAME}_sensor_{self.variable.name}"

    @property
    def functions(self) -> list[str]:
        """Numbered: the direction's components, or polynomials."""
        return [f"f{k + 1}" for k in range(3 if self.variable.name == GRAVITY else DRIFT_DEGREE)]

    def profile(self, robot: Robot, poses: Poses) -> Array:
        """Return the direction of gravity in the frame of the flange, or Legendre polynomials of the column."""
        if self.variable.name == GRAVITY:
            return np.einsum("nij,i->nj", robot.flange(poses.q)[:, :3, :3], robot.down)
        return legendre.legvander(self.variable.unit(poses), DRIFT_DEGREE)[:, 1:]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable, and whether the sensor turns."""
        return {"place": self.place, "variable": self.variable.to_mapping(), "turns": self.turns}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(Variable.from_mapping(mapping["variable"]), bool(mapping["turns"]))
