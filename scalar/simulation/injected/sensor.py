"""Errors of the sensor: a slip on the flange, and the laser's own range errors."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.effects import Rows
from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

LEVER = 1.0  # m; unless the entry states the angle, the sensor also turns by its shift over this length: 1 mrad with 1 mm


def draw_direction(rng: np.random.Generator) -> Array:
    """Return a random unit vector (3,), all directions being equally likely."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


@dataclass(frozen=True, eq=False)
class SensorSlip(InjectedEffect):
    """From one pose on, the sensor is shifted by size on the flange, and turned."""

    name: ClassVar[str] = "sensor_slip"
    unit: ClassVar[str] = "m"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the pose and the directions of shift and turn."""
        order = stage.draw_moment(rng, np.arange(len(stage.poses)))
        order = entry["target"].get("at", {}).get("order", order)
        turn = entry["size"] / LEVER if entry["turn_rad"] is None else entry["turn_rad"]
        details = {
            "shift_m": (entry["size"] * draw_direction(rng)).tolist(),
            "turn_rad": (turn * draw_direction(rng)).tolist(),
        }
        return cls({"at": stage.at(order)}, entry["size"], details)

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return the arm before and after the slip; for evaluation poses only the one after."""
        slipped = arm.shifted(
            {"t": np.array(self.details["shift_m"]), "r": np.array(self.details["turn_rad"])}
        )
        after = np.full(len(poses), True) if evaluating else poses["pose"] >= self.target["at"]["order"]
        return [(np.flatnonzero(~np.asarray(after)), arm), (np.flatnonzero(after), slipped)]


@dataclass(frozen=True, eq=False)
class RangeError(InjectedEffect):
    """An error of the laser's reading that depends on the reading alone."""

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing."""
        return cls({}, entry["size"], {"range_middle_m": _middle(stage)})

    def range_errors(self, readings: Array, angles: Array, poses: pd.DataFrame) -> Array:
        """Return the error of each reading."""
        return self.error(readings)

    @abstractmethod
    def error(self, readings: Array) -> Array:
        """Return the errors of readings (N, M) [m]."""


def _middle(stage: Stage) -> float:
    return (stage.workcell.scanner.range_near + stage.workcell.scanner.range_far) / 2


@dataclass(frozen=True, eq=False)
class RangeScale(RangeError):
    """Readings are 1 + size times the true ones."""

    name: ClassVar[str] = "range_scale"
    unit: ClassVar[str] = "m/m"

    def error(self, readings: Array) -> Array:
        """Return errors proportional to the readings."""
        return self.size * readings


@dataclass(frozen=True, eq=False)
class RangeOffset(RangeError):
    """Readings are too long by size."""

    name: ClassVar[str] = "range_offset"
    unit: ClassVar[str] = "m"

    def error(self, readings: Array) -> Array:
        """Return the size for every reading."""
        return np.full_like(readings, self.size)


@dataclass(frozen=True, eq=False)
class RangeDistortion(RangeError):
    """Readings are too long by size times the square of their distance from the middle of the range."""

    name: ClassVar[str] = "range_distortion"
    unit: ClassVar[str] = "1/m"

    def error(self, readings: Array) -> Array:
        """Return errors on a parabola about the middle of the range."""
        return self.size * (readings - self.details["range_middle_m"]) ** 2
