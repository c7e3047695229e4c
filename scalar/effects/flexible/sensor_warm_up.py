"""One component of the sensor's pose on the flange that changes as a warm-up does: the laser of a scanner, or its bracket, gets warm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.sensor import MovedSensor
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.flexible.variable import Variable
from scalar.effects.flexible.wander import COMPONENTS
from scalar.effects.growth import time_constant_steps
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class UnattributedSensorWarmUp(MovedSensor):
    """One component of the sensor's pose on the flange follows ``1 - exp(-t / constant)``, or a column in proportion.

    It is the rival of the growth of an arm that warms up: a scanner whose range drifts until it is warm has the same profile over time.

    Attributes:
        variable: The column that the change follows, with its measured range.
        component: One of ``COMPONENTS``.
        time_constant: Of the warm-up, in the unit of the column; zero for a change in proportion to it.
        turns: Not used by this term, whose component may be a rotation.
    """

    variable: Variable
    component: str
    time_constant: float = 0.0
    turns: bool = True

    place: ClassVar[str] = "sensor_warm_up"

    @property
    def key(self) -> str:
        """Name, variable, component and time constant."""
        return f"{NAME}_sensor_warm_up_{self.variable.name}_{self.component}_{self.time_constant:.3g}"

    @property
    def described_as(self) -> str:
        """Return that what is measured moves on the flange, or that the scanner's range drifts."""
        profile = "as a warm-up does" if self.time_constant else "steadily"
        return f"a motion of what sits on the flange, or a drift of its readings, that changes {profile} with {self._in_words}"

    @property
    def _in_words(self) -> str:
        return {"order": "the order of the poses", "time": "the time"}.get(
            self.variable.name, f"the {self.variable.name}"
        )

    @property
    def coefficient_names(self) -> list[str]:
        """The change of the component at the end of a warm-up, or over the measured range."""
        return [f"change_{self.component}_{'rad' if self.component.startswith('r') else 'm'}"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres or radians."""
        return ["rad" if self.component.startswith("r") else "m"]

    def variations(self, scale: float) -> list[Self]:
        """Return a warm-up that is a little faster or slower."""
        if not self.time_constant:
            return [self]
        return [replace(self, time_constant=self.time_constant * step) for step in time_constant_steps(scale)]

    def profile(self, robot: Robot, poses: Poses) -> Array:
        """Return the profile of the change ``(N, 1)``, from 0 at the beginning; constant outside of the measured range."""
        passed = (self.variable.unit(poses)[:, None] + 1.0) / 2.0
        if not self.time_constant:
            return passed
        return 1.0 - np.exp(-passed * 2.0 * self.variable.half / self.time_constant)

    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the one unit motion times the profile."""
        screws = np.zeros((len(poses), 6, 1))
        screws[:, COMPONENTS.index(self.component)] = self.profile(robot, poses)
        return screws

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable, component and time constant."""
        return {
            "place": self.place,
            "variable": self.variable.to_mapping(),
            "component": self.component,
            "time_constant": self.time_constant,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variable = Variable.from_mapping(mapping["variable"])
        return cls(variable, str(mapping["component"]), float(mapping["time_constant"]))


def sensor_warm_ups(name: str, values: Array, time_constant: float) -> list[UnattributedSensorWarmUp]:
    """Return a change of each component of the sensor's pose.

    Args:
        name: The column that they follow.
        values: ``(N,)``, its measured values.
        time_constant: Of a warm-up, in the unit of the column; zero for changes in proportion to it.
    """
    seen = Variable.observed(name, values)
    return [UnattributedSensorWarmUp(seen, component, time_constant) for component in COMPONENTS]
