"""Flexible terms for structure that no named effect explains: they correct, and say that they are no explanation.

Each is smooth in one or two variables: an error of one joint's angle, of one link's geometry, or of the sensor's pose. Polynomials are
clipped at the range of the data they were learned on, so that a prediction elsewhere does not run away.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.polynomial import legendre

from scalar.data.poses import Poses, is_joint
from scalar.effects.effect import Effect, JointEffect, LinkEffect, SensorEffect
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array

SINGLE_DEGREE = 6
PAIR_DEGREE = 3
DRIFT_DEGREE = 4
WOBBLE_ORDERS = (1, 2, 3)
PLATEAU_FLANK = 3.0  # steepness of its flanks, in units of half its width
WAVES = 3  # of a periodic error that is no sine
WAVE_STEP = 0.25  # between the orders that are tried, periods a turn
GRAVITY = "gravity"
NAME = "unattributed"


@dataclass(frozen=True)
class Variable:
    """A variable and the range of it that was seen: ``u = (x - centre) / half``, clipped to -1..1.

    Attributes:
        name: ``q3``, ``order``, ``time`` or another column.
        centre, half: In the unit of the column.
    """

    name: str
    centre: float
    half: float

    @classmethod
    def seen(cls, name: str, values: Array) -> Variable:
        """Return the variable with the range of the values seen."""
        low, high = float(np.min(values)), float(np.max(values))
        return cls(name, (low + high) / 2, max((high - low) / 2, 1e-12))

    def values(self, poses: Poses) -> Array:
        """Return the variable at poses, ``(N,)``, as it stands in the table; infinite orders are the end."""
        if is_joint(self.name):
            return poses.q[:, int(self.name[1:]) - 1]
        x = poses.order if self.name == "order" else poses.column(self.name)
        return np.where(np.isfinite(x), x, self.centre + self.half)

    def unit(self, poses: Poses) -> Array:
        """Return u ``(N,)``."""
        return np.clip((self.values(poses) - self.centre) / self.half, -1.0, 1.0)

    def to_mapping(self) -> dict[str, Any]:
        """Return name and range."""
        return {"name": self.name, "centre": self.centre, "half": self.half}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Variable:
        """Return the variable of ``to_mapping``."""
        return cls(str(mapping["name"]), float(mapping["centre"]), float(mapping["half"]))


def single_functions(variable: Variable, poses: Poses, degree: int = SINGLE_DEGREE) -> Array:
    """Return Legendre polynomials 1..degree, and for a joint its absolute value and sign, ``(N, k)``."""
    u = variable.unit(poses)
    columns = [legendre.legvander(u, degree)[:, 1:]]
    if variable.name.startswith("q"):
        x = variable.values(poses)
        columns.append(np.column_stack([np.abs(x) / variable.half, np.sign(x)]))
    return np.concatenate(columns, axis=1)


def pair_functions(a: Variable, b: Variable, poses: Poses) -> Array:
    """Return products of Legendre polynomials and of sines and cosines of two variables, ``(N, k)``."""
    P, Q = (legendre.legvander(v.unit(poses), PAIR_DEGREE)[:, 1:] for v in (a, b))
    products = (P[:, :, None] * Q[:, None, :]).reshape(len(P), -1)
    trig = [np.column_stack([np.sin(v.values(poses)), np.cos(v.values(poses))]) for v in (a, b)]
    waves = (trig[0][:, :, None] * trig[1][:, None, :]).reshape(len(P), -1)
    return np.concatenate([products, waves], axis=1)


class Unattributed(Effect):
    """What all flexible terms share: the name, and what they depend on."""

    name: ClassVar[str] = NAME
    sentence: ClassVar[str] = "structure that no known effect explains"

    @property
    def target(self) -> dict[str, Any]:
        """Nothing: it is not known what it acts on."""
        return {}

    @property
    def depends_on(self) -> list[str]:
        """Return the names of the variables."""
        raise NotImplementedError

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Any:
        """Return the term of ``to_mapping``."""
        return _PLACES[mapping["place"]].from_settings(mapping)


@dataclass(frozen=True, eq=False)
class UnattributedJoint(Unattributed, JointEffect):
    """A joint's angle errs smoothly with one or two variables."""

    joint: int
    variables: tuple[Variable, ...]

    @property
    def depends_on(self) -> list[str]:
        """Return the names of the variables."""
        return [v.name for v in self.variables]

    @property
    def key(self) -> str:
        """Name, joint and variables."""
        return "_".join([NAME, f"joint{self.joint}", *self.depends_on])

    @property
    def coefficient_names(self) -> list[str]:
        """Numbered functions."""
        if len(self.variables) == 1:
            count = SINGLE_DEGREE + (2 if self.variables[0].name.startswith("q") else 0)
        else:
            count = PAIR_DEGREE**2 + 4
        return [f"f{k + 1}_rad" for k in range(count)]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * len(self.coefficient_names)

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions on the joint."""
        if len(self.variables) == 1:
            functions = single_functions(self.variables[0], poses)
        else:
            functions = pair_functions(self.variables[0], self.variables[1], poses)
        B = np.zeros((len(poses), robot.n_joints, functions.shape[1]))
        B[:, self.joint - 1] = functions
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and variables."""
        return {"place": "joint", "joint": self.joint, "variables": [v.to_mapping() for v in self.variables]}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), tuple(Variable.from_mapping(v) for v in mapping["variables"]))


@dataclass(frozen=True, eq=False)
class UnattributedShape(UnattributedJoint):
    """A joint's angle errs in one simple way: a bump, a step or a kink at some value of a variable, a power of it, a product of two.

    One coefficient tells a few teeth that are worn, or an encoder that lost a count, from a sum of harmonics that imitates them.

    Attributes:
        variables: One, or the two of a product.
        shape: ``bump`` (of Gauss), ``plateau`` (one with a flat top), ``step`` (a hyperbolic tangent), ``kink`` (an absolute
            value), ``line``, ``square``, ``cube`` or ``product``.
        at, width: Of a bump, a step or a kink, in units of half the range of the variable that was seen.
    """

    shape: str
    at: float = 0.0
    width: float = 1.0

    @property
    def key(self) -> str:
        """Name, joint, variable and shape with its place."""
        return f"{super().key}_{self.shape}_{self.at:.3f}"

    @property
    def coefficient_names(self) -> list[str]:
        """The height."""
        return ["size_rad"]

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the shape on the joint."""
        u, *others = (variable.unit(poses) for variable in self.variables)
        s = (u - self.at) / self.width
        values = {
            "bump": lambda: np.exp(-(s**2) / 2),
            "plateau": lambda: (np.tanh(PLATEAU_FLANK * (s + 1)) - np.tanh(PLATEAU_FLANK * (s - 1))) / 2,
            "step": lambda: (np.tanh(s) + 1) / 2,
            "kink": lambda: np.abs(s),
            "line": lambda: u,
            "square": lambda: u**2,
            "cube": lambda: u**3,
            "product": lambda: u * others[0],
        }[self.shape]()
        B = np.zeros((len(poses), robot.n_joints, 1))
        B[:, self.joint - 1, 0] = values
        return B

    def variations(self, scale: float) -> list[Self]:
        """Return the shape moved by parts of its width, wider and narrower."""
        if self.shape not in ("bump", "plateau", "step", "kink"):
            return [self]
        return [
            replace(self, at=self.at + a * scale * self.width, width=self.width * 2.0 ** (b * scale))
            for a in (-1.0, -0.5, 0.0, 0.5, 1.0)
            for b in ((0.0,) if self.shape == "kink" else (-1.0, 0.0, 1.0))
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, variable and shape."""
        return super().to_mapping() | {
            "place": "shape",
            "shape": self.shape,
            "at": self.at,
            "width": self.width,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variables = tuple(Variable.from_mapping(v) for v in mapping["variables"])
        shape, at, width = str(mapping["shape"]), float(mapping["at"]), float(mapping["width"])
        return cls(int(mapping["joint"]), variables, shape, at, width)


@dataclass(frozen=True, eq=False)
class UnattributedWave(UnattributedJoint):
    """A joint's angle errs periodically in itself, but not in whole parts of its turn, as the gear's own errors are.

    Attributes:
        variables: The joint's own angle.
        order: Of the slowest wave, periods a turn; twice and three times as many go along.
    """

    order: float

    @property
    def key(self) -> str:
        """Name, joint and order."""
        return f"{super().key}_wave_{self.order:.3f}"

    @property
    def coefficient_names(self) -> list[str]:
        """Sine and cosine of each wave."""
        return [f"{f}{k + 1}_rad" for k in range(WAVES) for f in ("sin", "cos")]

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the waves on the joint."""
        q = poses.q[:, self.joint - 1]
        B = np.zeros((len(poses), robot.n_joints, 2 * WAVES))
        for k in range(WAVES):
            B[:, self.joint - 1, 2 * k] = np.sin((k + 1) * self.order * q)
            B[:, self.joint - 1, 2 * k + 1] = np.cos((k + 1) * self.order * q)
        return B

    def variations(self, scale: float) -> list[Self]:
        """Return waves a little slower and faster."""
        step = scale * WAVE_STEP / 2
        return [replace(self, order=self.order + a * step) for a in (-1.0, -0.5, 0.0, 0.5, 1.0)]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, variable and order."""
        return super().to_mapping() | {"place": "wave", "order": self.order}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variables = tuple(Variable.from_mapping(v) for v in mapping["variables"])
        return cls(int(mapping["joint"]), variables, float(mapping["order"]))


@dataclass(frozen=True, eq=False)
class UnattributedLink(Unattributed, LinkEffect):
    """A link's geometry errs with its joint's own angle (an axis that wobbles) or with the direction of gravity (a link that bends).

    Attributes:
        joint: From 1.
        by: ``q<joint>`` or ``gravity``.
    """

    joint: int
    by: str

    @property
    def depends_on(self) -> list[str]:
        """Return what drives the error: a joint's angle, or gravity."""
        return [self.by]

    @property
    def key(self) -> str:
        """Name, joint and driver."""
        return f"{NAME}_link{self.joint}_{self.by}"

    @property
    def _functions(self) -> list[str]:
        if self.by == GRAVITY:
            return ["gx", "gy", "gz"]
        return [f"{f}{k}" for k in WOBBLE_ORDERS for f in ("sin", "cos")]

    @property
    def coefficient_names(self) -> list[str]:
        """Every function for every kind of geometry."""
        return [
            f"{kind}_{f}_{'m' if kind in LENGTHS else 'rad'}" for kind in GEOMETRY for f in self._functions
        ]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m" if kind in LENGTHS else "rad" for kind in GEOMETRY for _ in self._functions]

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions at every kind of geometry of the joint."""
        if self.by == GRAVITY:
            down = robot.gravity / max(float(np.linalg.norm(robot.gravity)), 1e-12)
            functions = np.einsum("nij,i->nj", robot.frames(poses.q)[:, self.joint - 1, :3, :3], down)
        else:
            q = poses.q[:, self.joint - 1]
            functions = np.stack([f(k * q) for k in WOBBLE_ORDERS for f in (np.sin, np.cos)], axis=1)
        w = functions.shape[1]
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(GEOMETRY) * w))
        for k in range(len(GEOMETRY)):
            basis[:, k, self.joint - 1, k * w : (k + 1) * w] = functions
        return basis

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and driver."""
        return {"place": "link", "joint": self.joint, "by": self.by}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), str(mapping["by"]))


class MovedSensor(Unattributed, SensorEffect):
    """The sensor's pose on the flange errs: shifts, and turns where they can be seen, each times some functions of the pose.

    Subclasses are dataclasses with the fields ``variable`` and ``turns``.
    """

    variable: Variable
    turns: bool

    @property
    def functions(self) -> list[str]:
        """Return the names of the functions."""
        raise NotImplementedError

    def course(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions ``(N, k)``, dimensionless."""
        raise NotImplementedError

    @property
    def depends_on(self) -> list[str]:
        """Return the column, or the direction of gravity."""
        return [self.variable.name]

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
        """Return unit motions times the functions."""
        unit = np.zeros((6, 6 if self.turns else 3))
        unit[3:, :3] = np.eye(3)
        if self.turns:
            unit[:3, 3:] = np.eye(3)
        course = self.course(robot, poses)
        return (course[:, None, :, None] * unit[None, :, None, :]).reshape(len(poses), 6, -1)


@dataclass(frozen=True, eq=False)
class UnattributedSensor(MovedSensor):
    """The sensor's pose on the flange errs with the direction of gravity, or drifts with a column."""

    variable: Variable
    turns: bool = True

    @property
    def key(self) -> str:
        """Name and variable."""
        return f"{NAME}_sensor_{self.variable.name}"

    @property
    def functions(self) -> list[str]:
        """Numbered: the direction's components, or polynomials."""
        return [f"f{k + 1}" for k in range(3 if self.variable.name == GRAVITY else DRIFT_DEGREE)]

    def course(self, robot: Robot, poses: Poses) -> Array:
        """Return the direction of gravity seen from the flange, or Legendre polynomials of the column."""
        if self.variable.name == GRAVITY:
            down = robot.gravity / max(float(np.linalg.norm(robot.gravity)), 1e-12)
            return np.einsum("nij,i->nj", robot.flange(poses.q)[:, :3, :3], down)
        return legendre.legvander(self.variable.unit(poses), DRIFT_DEGREE)[:, 1:]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable and what is seen."""
        return {"place": "sensor", "variable": self.variable.to_mapping(), "turns": self.turns}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(Variable.from_mapping(mapping["variable"]), bool(mapping["turns"]))


@dataclass(frozen=True, eq=False)
class UnattributedSway(MovedSensor):
    """The sensor's pose on the flange sways with the course of the acquisition, and rests outside of it.

    Attributes:
        variable: ``time`` or ``order``.
        periods: In the range that was seen.
        turns: Whether it turns as well as shifts.
    """

    variable: Variable
    periods: float
    turns: bool = True

    @property
    def key(self) -> str:
        """Name, variable and periods."""
        return f"{NAME}_sway_{self.variable.name}_{self.periods:.2f}"

    @property
    def functions(self) -> list[str]:
        """Sine and cosine."""
        return ["sin", "cos"]

    def course(self, robot: Robot, poses: Poses) -> Array:
        """Return sine and cosine of the course, zero before it and from its end on."""
        values = self.variable.values(poses)
        start = self.variable.centre - self.variable.half
        seen = (values >= start) & (values < start + 2 * self.variable.half)
        phase = np.pi * self.periods * self.variable.unit(poses)
        return np.stack([np.sin(phase), np.cos(phase)], axis=1) * seen[:, None]

    def variations(self, scale: float) -> list[Self]:
        """Return the sway a little slower and faster."""
        return [
            replace(self, periods=max(self.periods + a * scale, 0.1)) for a in (-0.5, -0.25, 0.0, 0.25, 0.5)
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, variable and periods."""
        return {
            "place": "sway",
            "variable": self.variable.to_mapping(),
            "periods": self.periods,
            "turns": self.turns,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variable = Variable.from_mapping(mapping["variable"])
        return cls(variable, float(mapping["periods"]), bool(mapping["turns"]))


_PLACES: dict[str, Any] = {
    "joint": UnattributedJoint,
    "shape": UnattributedShape,
    "wave": UnattributedWave,
    "link": UnattributedLink,
    "sensor": UnattributedSensor,
    "sway": UnattributedSway,
}
