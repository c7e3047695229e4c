"""One component of the sensor's pose on the flange that wanders in the course of the acquisition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.sensor import MovedSensor
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.flexible.variable import Variable
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

COMPONENTS = ("rx", "ry", "rz", "x", "y", "z")  # components of a screw, rotations first
HALF_WAVES = 8  # number of half waves over the acquisition


@dataclass(frozen=True, eq=False)
class UnattributedWander(MovedSensor):
    """One component of the sensor's pose on the flange wanders: eight half waves over the acquisition; outside of it the term is zero.

    Zero is its mean over the acquisition. Predictions for later poses are thus those for the mean pose of the sensor: whether it will go on from
    where it was last, or swing back, cannot be known of a motion without a name.

    The first few such waves make up nine tenths of the variance of a random walk (its Karhunen-Loève expansion). Only one component wanders,
    because eight waves for each of six components would be more coefficients than some hundred poses determine.

    Attributes:
        variable: ``time`` or ``order``.
        component: One of ``COMPONENTS``.
        turns: Not used by this term, whose component may be a rotation.
    """

    variable: Variable
    component: str
    turns: bool = True

    place: ClassVar[str] = "wander"

    @property
    def key(self) -> str:
        """Name, variable and component."""
        return f"{NAME}_wander_{self.variable.name}_{self.component}"

    @property
    def functions(self) -> list[str]:
        """Numbered half waves."""
        return [f"c{k}" for k in range(1, HALF_WAVES + 1)]

    @property
    def coefficient_names(self) -> list[str]:
        """Every half wave of the one component."""
        unit = "rad" if self.component.startswith("r") else "m"
        return [f"{function}_{self.component}_{unit}" for function in self.functions]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres or radians."""
        return ["rad" if self.component.startswith("r") else "m"] * HALF_WAVES

    def profile(self, robot: Robot, poses: Poses) -> Array:
        """Return cosines with whole numbers of half waves over the acquisition, zero before it and from its end on."""
        phase = np.pi * (self.variable.unit(poses) + 1.0) / 2.0
        return np.cos(phase[:, None] * np.arange(1, HALF_WAVES + 1)) * self.variable.within(poses)[:, None]

    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the one unit motion times the half waves."""
        profile = self.profile(robot, poses)
        screws = np.zeros((len(poses), 6, HALF_WAVES))
        screws[:, COMPONENTS.index(self.component)] = profile
        return screws

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable and component."""
        return {"place": self.place, "variable": self.variable.to_mapping(), "component": self.component}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(Variable.from_mapping(mapping["variable"]), str(mapping["component"]))
