"""The sensor's pose on the flange that sways in the course of the acquisition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.sensor import MovedSensor
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.flexible.variable import Variable
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class UnattributedSway(MovedSensor):
    """The sensor's pose on the flange sways as a sine in the course of the acquisition; outside it the sensor has its mean pose.

    Attributes:
        variable: ``time`` or ``order``.
        periods: Number of periods in the measured range of the variable.
        turns: Whether it turns as well as shifts.
    """

    variable: Variable
    periods: float
    turns: bool = True

    place: ClassVar[str] = "sway"

    @property
    def key(self) -> str:
        """Name, variable and periods."""
        return f"{NAME}_sway_{self.variable.name}_{self.periods:.2f}"

    @property
    def functions(self) -> list[str]:
        """Sine and cosine."""
        return ["sin", "cos"]

    def profile(self, robot: Robot, poses: Poses) -> Array:
        """Return sine and cosine over the acquisition, and before it and from its end on their means over it.

        The means are not zero: the periods are seldom whole, and a slow cosine hardly changes its sign.
        """
        phase = np.pi * self.periods * self.variable.unit(poses)
        waves = np.stack([np.sin(phase), np.cos(phase)], axis=1)
        means = np.array([0.0, np.sinc(self.periods)])
        return np.where(self.variable.within(poses)[:, None], waves, means)

    def variations(self, scale: float) -> list[Self]:
        """Return the sway a little slower and faster."""
        return [
            replace(self, periods=max(self.periods + a * scale, 0.1)) for a in (-0.5, -0.25, 0.0, 0.25, 0.5)
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable and periods."""
        return {
            "place": self.place,
            "variable": self.variable.to_mapping(),
            "periods": self.periods,
            "turns": self.turns,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variable = Variable.from_mapping(mapping["variable"])
        return cls(variable, float(mapping["periods"]), bool(mapping["turns"]))
