"""Errors of the joint angles: compliance, harmonics, scale, coupling, backlash."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import JointEffect, OneJoint
from scalar.effects.gravity import AXES, torque_basis, torque_of, typical_torque
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class JointCompliance(JointEffect):
    """Joints give way under the weight of the arm: ``dq_j = sum over frames of c . (torque of a unit first moment)``.

    Attributes:
        terms: (joint, frame) pairs, from 1: the frame's first moment of mass acts on the joint. Two coefficients a pair.
    """

    terms: tuple[tuple[int, int], ...]

    name: ClassVar[str] = "joint_compliance"
    sentence: ClassVar[str] = "the joints give way under the weight of the arm"

    @property
    def target(self) -> dict[str, Any]:
        """The joints that give way."""
        return {"joints": sorted({joint for joint, _ in self.terms})}

    @property
    def coefficient_names(self) -> list[str]:
        """``joint2_frame3_x_rad``: deflection of joint 2 at full leverage of a moment along x of frame 3."""
        return [f"joint{j}_frame{f}_{axis}_rad" for j, f in self.terms for axis in AXES]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.terms))

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the torques of unit first moments, each on its joint."""
        B = np.zeros((len(poses), robot.n_joints, 2 * len(self.terms)))
        for k, (joint, frame) in enumerate(self.terms):
            B[:, joint - 1, 2 * k : 2 * k + 2] = torque_basis(robot, poses.q, joint, frame)
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return the terms."""
        return {"terms": [list(term) for term in self.terms]}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple((int(j), int(f)) for j, f in mapping["terms"]))


@dataclass(frozen=True, eq=False)
class JointHarmonic(JointEffect):
    """A joint's angle errs periodically in itself: ``dq_j = sum_k s_k sin(k q_j) + c_k cos(k q_j)``.

    Attributes:
        joint: From 1.
        orders: From 1 to 32.
        believed: [rad], one standard deviation of what is believed of each order's coefficients before any data; empty for the common belief.
    """

    joint: int
    orders: tuple[int, ...]
    believed: tuple[float, ...] = field(default=(), kw_only=True)

    name: ClassVar[str] = "joint_harmonic"
    sentence: ClassVar[str] = "the angle errs periodically in itself, as eccentric gears make it"

    @property
    def target(self) -> dict[str, Any]:
        """The joint with its order, or orders."""
        if len(self.orders) == 1:
            return {"joint": self.joint, "order": self.orders[0]}
        return {"joint": self.joint, "orders": list(self.orders)}

    @property
    def coefficient_names(self) -> list[str]:
        """``sin_rad, cos_rad``, with the order where there are several."""
        if len(self.orders) == 1:
            return ["sin_rad", "cos_rad"]
        return [f"{f}{k}_rad" for k in self.orders for f in ("sin", "cos")]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.orders))

    @property
    def plausible_sizes(self) -> Array:
        """Return the common belief, or that of each order."""
        return np.repeat(self.believed, 2) if self.believed else super().plausible_sizes

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return sine and cosine of the multiples of the angle."""
        B = np.zeros((len(poses), robot.n_joints, 2 * len(self.orders)))
        phase = poses.q[:, self.joint - 1, None] * np.array(self.orders)
        B[:, self.joint - 1, 0::2], B[:, self.joint - 1, 1::2] = np.sin(phase), np.cos(phase)
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return joint and orders, and what is believed of their sizes where that is their own."""
        own = {"believed_rad": list(self.believed)} if self.believed else {}
        return {"joint": self.joint, "orders": list(self.orders), **own}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        believed = tuple(float(size) for size in mapping.get("believed_rad", ()))
        return cls(int(mapping["joint"]), tuple(int(k) for k in mapping["orders"]), believed=believed)


@dataclass(frozen=True, eq=False)
class JointRipple(JointHarmonic):
    """The same in orders above 32: finer than eccentric gears make it, as teeth, motor poles and encoder lines do."""

    name: ClassVar[str] = "joint_ripple"
    sentence: ClassVar[str] = "the angle errs periodically in itself, finer than eccentric gears make it"


@dataclass(frozen=True, eq=False)
class JointScale(OneJoint, JointEffect):
    """A joint's angle errs in proportion to itself: ``dq_j = s q_j``.

    Attributes:
        joint: From 1.
    """

    joint: int

    name: ClassVar[str] = "joint_scale"
    sentence: ClassVar[str] = "the angle errs in proportion to itself"

    @property
    def coefficient_names(self) -> list[str]:
        """``scale_rad_per_rad``."""
        return ["scale_rad_per_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians a radian."""
        return ["rad/rad"]

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the angle itself."""
        B = np.zeros((len(poses), robot.n_joints, 1))
        B[:, self.joint - 1, 0] = poses.q[:, self.joint - 1]
        return B


@dataclass(frozen=True, eq=False)
class JointCoupling(JointEffect):
    """One joint's angle leaks into another's: ``dq_j = c q_source``.

    Attributes:
        joint: That errs, from 1.
        source: That leaks, from 1.
    """

    joint: int
    source: int

    name: ClassVar[str] = "joint_coupling"
    sentence: ClassVar[str] = "one joint's angle leaks into another's, as in wrist gears"

    @property
    def target(self) -> dict[str, Any]:
        """The joint and its source."""
        return {"joint": self.joint, "source": self.source}

    @property
    def coefficient_names(self) -> list[str]:
        """``coupling_rad_per_rad``."""
        return ["coupling_rad_per_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians a radian."""
        return ["rad/rad"]

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the source's angle on the joint."""
        B = np.zeros((len(poses), robot.n_joints, 1))
        B[:, self.joint - 1, 0] = poses.q[:, self.source - 1]
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return joint and source."""
        return {"joint": self.joint, "source": self.source}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(int(mapping["joint"]), int(mapping["source"]))


@dataclass(frozen=True, eq=False)
class JointBacklash(JointEffect):
    """A joint rests on one side of its play or the other: ``dq_j = b s``, s the direction of approach or the torque's sign.

    Attributes:
        joint: From 1.
        by: ``approach``, or ``torque`` where directions are not recorded.
        masses: First moments of mass in the frames from the joint on, x and y of each in turn, in any unit: only
            the sign of the torque matters. Empty: those of an arm with equal masses at the ends of its links.
    """

    joint: int
    by: str
    masses: tuple[float, ...] = ()

    name: ClassVar[str] = "joint_backlash"
    sentence: ClassVar[str] = "the joint rests on one side of its play or the other"

    @property
    def target(self) -> dict[str, Any]:
        """The joint."""
        return {"joint": self.joint}

    @property
    def coefficient_names(self) -> list[str]:
        """``half_width_rad``."""
        return ["half_width_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"]

    def torque(self, robot: Robot, q: Array) -> Array:
        """Return the torque ``(N,)`` whose sign says on which side the joint rests, in any unit."""
        if self.masses:
            return torque_of(robot, q, self.joint, self.masses)
        return typical_torque(robot, q, self.joint)

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the side on which the joint rests, -1 or 1."""
        B = np.zeros((len(poses), robot.n_joints, 1))
        if self.by == "approach":
            side = poses.column(f"approach{self.joint}")
        else:
            side = np.sign(self.torque(robot, poses.q))
        B[:, self.joint - 1, 0] = side
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint and what tells the side."""
        return {"joint": self.joint, "by": self.by} | ({"masses": list(self.masses)} if self.masses else {})

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(
            int(mapping["joint"]), str(mapping["by"]), tuple(float(m) for m in mapping.get("masses", ()))
        )

    def variations(self, scale: float) -> list[Self]:
        """Return the same with one first moment of mass a little larger or smaller: the torque's sign turns elsewhere."""
        step = scale * float(np.linalg.norm(self.masses)) / 2
        result = [self]
        for k in range(len(self.masses)):
            for side in (-step, step):
                result.append(
                    replace(self, masses=tuple(m + side * (i == k) for i, m in enumerate(self.masses)))
                )
        return result
