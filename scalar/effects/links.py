"""Errors of the links: a tilt between near-parallel axes that modified DH cannot hold, and lengths that grow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import LinkEffect, OneJoint
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class AxisNonparallel(OneJoint, LinkEffect):
    """The angle about y between near-parallel axes, Hayati's beta, that four DH parameters cannot hold.

    Attributes:
        joint: From 1.
    """

    joint: int

    name: ClassVar[str] = "axis_nonparallel"
    sentence: ClassVar[str] = (
        "the axis is tilted against the one before in the way that modified DH cannot hold"
    )

    @property
    def coefficient_names(self) -> list[str]:
        """``beta_rad``, on top of the nominal one."""
        return ["beta_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"]

    @property
    def plausible_sizes(self) -> Array:
        """Return three degrees: an error of assembly, larger than what bends or wears."""
        return np.array([0.05])

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return a one at beta of the joint."""
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, 1))
        basis[:, GEOMETRY.index("beta"), self.joint - 1, 0] = 1.0
        return basis


@dataclass(frozen=True, eq=False)
class ThermalDrift(LinkEffect):
    """All lengths of the arm grow alike: ``a, d -> (1 + g x) a, d``, x the temperature, or a course of time.

    Attributes:
        by: ``temperature``, ``time`` or ``order``: the column that drives the growth.
        reference: Value of the column at which the lengths are those of the model.
        time_constant: Of a warm-up ``1 - exp(-(t - reference) / time_constant)``; zero for growth in proportion.
        last: Last order of acquisition: where predictions without ``order`` stand. None where it is not known.
    """

    by: str
    reference: float
    time_constant: float = 0.0
    last: float | None = None

    name: ClassVar[str] = "thermal_drift"
    sentence: ClassVar[str] = "the arm's lengths grow with time or temperature"

    @property
    def target(self) -> dict[str, Any]:
        """Nothing: the whole arm."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """Growth a kelvin, a second, a pose; or the whole growth of a warm-up."""
        if self.time_constant:
            return ["growth_m_per_m"]
        return [{"temperature": "growth_per_K", "time": "growth_per_s", "order": "growth_per_pose"}[self.by]]

    @property
    def coefficient_units(self) -> list[str]:
        """As the names say."""
        if self.time_constant:
            return ["m/m"]
        return [{"temperature": "1/K", "time": "1/s", "order": "1/pose"}[self.by]]

    def variations(self, scale: float) -> list[Self]:
        """Return a warm-up that is a little faster or slower."""
        if not self.time_constant:
            return [self]
        return [
            replace(self, time_constant=self.time_constant * 3.0 ** (a * scale))
            for a in (-0.5, -0.25, 0.0, 0.25, 0.5)
        ]

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the nominal lengths times the course of the growth."""
        driver = self._order(poses) if self.by == "order" else poses.column(self.by)
        x = driver - self.reference
        if self.time_constant:
            x = 1.0 - np.exp(-np.maximum(x, 0.0) / self.time_constant)
        lengths = np.array([kind in LENGTHS for kind in GEOMETRY])[:, None] * robot.geometry
        return x[:, None, None, None] * lengths[None, :, :, None]

    def _order(self, poses: Poses) -> Array:
        """Return the order of acquisition ``(N,)``, the end of it where none is stated."""
        if np.all(np.isfinite(poses.order)):
            return poses.order
        return np.where(
            np.isfinite(poses.order), poses.order, poses.column("order") if self.last is None else self.last
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return what drives the growth."""
        mapping: dict[str, Any] = {
            "by": self.by,
            "reference": self.reference,
            "time_constant": self.time_constant,
        }
        return mapping if self.last is None else {**mapping, "last": self.last}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        last = mapping.get("last")
        return cls(
            str(mapping["by"]),
            float(mapping["reference"]),
            float(mapping["time_constant"]),
            None if last is None else float(last),
        )
