"""Errors of the sensor: a slip on the flange, and the laser's own range errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import PointEffect, SensorEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

_COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class SensorSlip(SensorEffect):
    """The sensor sits elsewhere on the flange from a pose on.

    Attributes:
        order: Order of acquisition of the first pose after the slip.
        time: Its time [s], or None.
        turns: Whether the rotation is seen as well (a probe's is not).
    """

    order: float
    time: float | None = None
    turns: bool = True

    name: ClassVar[str] = "sensor_slip"
    sentence: ClassVar[str] = "the sensor shifts on the flange from one pose on"

    @property
    def target(self) -> dict[str, Any]:
        """When."""
        return {"at": {"order": self.order, "time": self.time}}

    @property
    def coefficient_names(self) -> list[str]:
        """Translation and rotation in the sensor's frame."""
        names = [f"{c}_m" for c in _COMPONENTS[:3]]
        return names + [f"{c}_rad" for c in _COMPONENTS[3:]] if self.turns else names

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m"] * 3 + (["rad"] * 3 if self.turns else [])

    @property
    def plausible_sizes(self) -> Array:
        """Return two centimetres and three degrees: what is knocked moves far."""
        return np.array([0.02 if unit == "m" else 0.05 for unit in self.coefficient_units])

    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return unit screws after the slip, zero before."""
        after = (poses.order >= self.order).astype(float)
        unit = np.zeros((6, len(self.coefficient_names)))
        unit[3:, :3] = np.eye(3)
        if self.turns:
            unit[:3, 3:] = np.eye(3)
        return after[:, None, None] * unit

    def to_mapping(self) -> dict[str, Any]:
        """Return when, and what is seen."""
        return {"order": self.order, "time": self.time, "turns": self.turns}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        time = mapping["time"]
        return cls(float(mapping["order"]), None if time is None else float(time), bool(mapping["turns"]))


@dataclass(frozen=True, eq=False)
class _RangeError(PointEffect):
    """An error of the measured range along the direction in which the scanner errs: one coefficient."""

    @property
    def target(self) -> dict[str, Any]:
        """Nothing: the sensor."""
        return {}

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the sensor's axes against the normal: a point corrected by ``c phi(p)`` moves off the plate by that."""
        return contact[:, 1:, None]

    def to_mapping(self) -> dict[str, Any]:
        """Return nothing: the name says all."""
        return {}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect."""
        return cls()


@dataclass(frozen=True, eq=False)
class RangeScale(_RangeError):
    """The measured range needs to be stretched: ``r -> (1 + s) r``."""

    name: ClassVar[str] = "range_scale"
    sentence: ClassVar[str] = "the laser's gain is off"
    basis_names: ClassVar[tuple[str, ...]] = ("rx", "rz")

    @property
    def coefficient_names(self) -> list[str]:
        """``gain_m_per_m``."""
        return ["gain_m_per_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres a metre."""
        return ["m/m"]


@dataclass(frozen=True, eq=False)
class RangeOffset(_RangeError):
    """The measured range needs a constant: ``r -> r + o``."""

    name: ClassVar[str] = "range_offset"
    sentence: ClassVar[str] = "the laser's zero is off"
    basis_names: ClassVar[tuple[str, ...]] = ("ux", "uz")

    @property
    def coefficient_names(self) -> list[str]:
        """``offset_m``."""
        return ["offset_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"]


@dataclass(frozen=True, eq=False)
class RangeDistortion(_RangeError):
    """The measured range is curved: ``r -> r + k (r - m)^2 + s r + o``.

    Gain and zero go with a parabola wherever its middle lies, and a gain cannot be seen: it is held at what the laser says of itself at
    ``middle``. In the middle of what was measured a curvature then moves the lengths of the arm least.

    Attributes:
        middle: m [m].
    """

    middle: float = 0.0

    name: ClassVar[str] = "range_distortion"
    sentence: ClassVar[str] = "the laser's range is curved"
    basis_names: ClassVar[tuple[str, ...]] = ("dx", "dz", "rx", "rz", "ux", "uz")

    @property
    def coefficient_names(self) -> list[str]:
        """Curvature, and the gain and zero that go with it."""
        return ["curvature_per_m", "gain_m_per_m", "offset_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """One over metres, metres a metre, metres."""
        return ["1/m", "m/m", "m"]

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the sensor's axes against the normal, for each of the three functions of the range."""
        G = np.zeros((len(contact), 6, 3))
        for k in range(3):
            G[:, 2 * k : 2 * k + 2, k] = contact[:, 1:]
        G[:, 2:4, 0] = -2.0 * self.middle * contact[:, 1:]
        G[:, 4:6, 0] = self.middle**2 * contact[:, 1:]
        return G

    def to_mapping(self) -> dict[str, Any]:
        """Return the middle."""
        return {"middle_m": self.middle}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(float(mapping.get("middle_m", 0.0)))
