"""What an effect is: a regressor at a place, linear in a few coefficients.

Where an effect acts decides its columns, and everything needed is already there: the screw of the joint, of the link, of the base
or of the sensor that it moves. A subclass of one of the places below states its columns for given poses; the model applies
the correction exactly, and its derivative is the place's screw times the column.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

PLAUSIBLE_SIZE = {
    "rad": 3e-3,
    "m": 0.02,
    "rad/rad": 0.02,
    "m/m": 0.02,
    "1/m": 0.1,
    "1/K": 1e-3,
}
"""By unit: what a coefficient of a real cell hardly ever exceeds. A unit that is not listed is not bounded."""


@dataclass(frozen=True, eq=False)
class Effect(ABC):
    """One effect with its coefficients.

    Attributes:
        coefficients: ``(k,)``, in the units of ``coefficient_units``.
    """

    coefficients: Array = field(default_factory=lambda: np.zeros(0), kw_only=True)

    name: ClassVar[str]
    sentence: ClassVar[str]

    def __post_init__(self) -> None:
        if self.coefficients.size == 0:
            object.__setattr__(self, "coefficients", np.zeros(len(self.coefficient_names)))

    @property
    @abstractmethod
    def target(self) -> dict[str, Any]:
        """What the effect acts on, as ``diagnosis.json`` writes it."""

    @property
    @abstractmethod
    def coefficient_names(self) -> list[str]:
        """Names of the coefficients, their unit at the end."""

    @property
    @abstractmethod
    def coefficient_units(self) -> list[str]:
        """Units of the coefficients."""

    @property
    def plausible_sizes(self) -> Array:
        """Return ``(k,)``: one standard deviation of what is believed of the coefficients before any data.

        Far larger than any effect worth finding, so that it shrinks nothing that is seen; it keeps combinations of columns that the
        data hardly see from growing without bound.
        """
        return np.array([PLAUSIBLE_SIZE.get(unit, np.inf) for unit in self.coefficient_units])

    @abstractmethod
    def to_mapping(self) -> dict[str, Any]:
        """Return what is needed to make the same effect again, besides its name and coefficients."""

    @classmethod
    @abstractmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``, its coefficients zero."""

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with what is not linear in it a little changed, in steps of ``scale`` of what a first look resolves."""
        return [self]

    @property
    def key(self) -> str:
        """A name that tells this effect from every other in a model: name and target."""
        parts = []
        for value in self.target.values():
            if isinstance(value, dict):
                parts.append(f"{value['order']:g}")
            elif not isinstance(value, list):
                parts.append(f"{value}")
        return "_".join([self.name, *parts])

    @property
    def parameter_names(self) -> list[str]:
        """Names of the coefficients in tables of all parameters."""
        return [f"{self.key}.{name}" for name in self.coefficient_names]

    def with_coefficients(self, coefficients: Sequence[float] | Array) -> Self:
        """Return the same effect with other coefficients ``(k,)``."""
        return replace(self, coefficients=np.array(coefficients, dtype=float))


class OneJoint(Effect):
    """An effect that one joint names in full: a dataclass field ``joint``, counted from 1, and nothing else."""

    joint: int

    @property
    def target(self) -> dict[str, Any]:
        """The joint."""
        return {"joint": self.joint}

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint."""
        return {"joint": self.joint}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(joint=int(mapping["joint"]))  # type: ignore[call-arg]


class JointEffect(Effect):
    """An error of the joint angles, ``dq = B c``: the arm stands at ``q + dq`` where the encoders read q."""

    @abstractmethod
    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return B ``(N, n, k)`` [rad per unit]; ``robot`` is the nominal one."""


class LinkEffect(Effect):
    """A change of the geometric parameters, pose by pose."""

    @abstractmethod
    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the change ``(N, 5, n, k)`` of ``Robot.geometry`` [m or rad per unit]."""


class BaseEffect(Effect):
    """A motion of the whole arm, left of everything."""

    @abstractmethod
    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return screws ``(N, 6, k)`` in the base frame [rad, m per unit]."""


class SensorEffect(Effect):
    """A motion of the sensor on the flange, right of everything."""

    @abstractmethod
    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return screws ``(N, 6, k)`` in the sensor's frame [rad, m per unit]."""


class PointEffect(Effect):
    """An error of the measured points or of the surface: it adds functions of the points to the residual.

    ``f_i += sum_b basis_b(p_i) (G c)_b``, the functions as ``scalar.sensors.profile.point_basis`` names them.
    """

    basis_names: ClassVar[tuple[str, ...]]

    @abstractmethod
    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return G ``(N, len(basis_names), k)`` [m per unit of the coefficients, for the functions of the basis]."""
