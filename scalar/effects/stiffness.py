"""Joints that give way in proportion to a torque that is known at each pose: ``dq_j = s_j tau_j``, one compliance a joint."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import turning_joints
from scalar.effects.command_words import all_turning_named
from scalar.effects.described import Table
from scalar.effects.effect import Effect
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import JointEffect
from scalar.effects.wording import stiffness_row
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_UNIT = "rad/(N m)"
_SEEN = 2.0  # standard errors from which a compliance is one
_STILL = 1e-6  # N m: a torque that varies by less cannot show a compliance


@dataclass(frozen=True, eq=False)
class KnownTorques(JointEffect):
    """Joints that give way under torques that are known.

    Attributes:
        joints: From 1, in their order; one coefficient each.
    """

    joints: tuple[int, ...]

    most_words: ClassVar[int] = 100  # as many joints as an arm may have
    torque_words: ClassVar[str]  # what the torque on a joint is called, without the joint
    natural: ClassVar[Mapping[str, float]] = {_UNIT: 6e-6}
    natural_source: ClassVar[str] = "a gear of 49 N m per arc minute (Nabtesco RV-20E, catalogue)"
    acts_by_joint_angles: ClassVar[bool] = False
    needs_records: ClassVar[bool] = True

    @abstractmethod
    def torques(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque on every joint ``(N, n)`` [N m]; ``robot`` is the nominal one."""

    @property
    def target(self) -> dict[str, Any]:
        """The joints that give way."""
        return {"joints": list(self.joints)}

    @property
    def coefficient_names(self) -> list[str]:
        """``joint2_rad_per_Nm``: compliance of joint 2."""
        return [f"joint{j}_rad_per_Nm" for j in self.joints]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians for each newton metre."""
        return [_UNIT] * len(self.joints)

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return each joint's own torque."""
        torques = self.torques(robot, poses)
        B = np.zeros((*torques.shape, len(self.joints)))
        for k, joint in enumerate(self.joints):
            B[:, joint - 1, k] = torques[:, joint - 1]
        return B

    def to_mapping(self) -> dict[str, Any]:
        """Return the joints."""
        return {"joints": list(self.joints)}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple(int(j) for j in mapping["joints"]))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the compliance of every joint that turns and whose torque is recorded and varies, and that of all of them together."""
        if cls.unknown(dataset) is not None:
            return []
        joints = tuple(turning_joints(dataset))
        torques = cls(joints).torques(dataset.robot, dataset.known_poses)
        seen = tuple(j for j in joints if np.ptp(torques[:, j - 1]) > _STILL)
        alone: list[Effect] = [cls((j,)) for j in seen]
        return [*alone, cls(seen)] if len(seen) > 1 else alone

    @classmethod
    @abstractmethod
    def unknown(cls, dataset: Dataset) -> str | None:
        """Return a sentence on what is missing for the torques to be known; None where they are known."""

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the compliance of the joints that are named, or of all joints, as one effect."""
        missing = cls.unknown(dataset)
        if missing is not None:
            raise ValueError(missing)
        return [cls(all_turning_named(dataset, words))]

    def stiffness(self, std: Sequence[float | None]) -> list[tuple[int, float, float | None]]:
        """Return joint, stiffness 1 / abs(s) and its standard error std / s^2 [N m/rad].

        Where the compliance s is less than two standard errors, these are NaN and 1 / (abs(s) + 2 std). The sign of s is that of the recorded torque.
        """
        found: list[tuple[int, float, float | None]] = []
        for joint, s, error in zip(self.joints, np.abs(self.coefficients).tolist(), std, strict=True):
            if s > _SEEN * (error or 0.0):
                found.append((joint, 1.0 / s, None if error is None else error / s**2))
            elif error:
                found.append((joint, float("nan"), 1.0 / (s + _SEEN * error)))
        return found

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return the compliances, then the stiffnesses that follow from them."""
        head, rows = super().table(std) or ((), [])
        return head, [*rows, *(stiffness_row(*found) for found in self.stiffness(std))]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return what is missing."""
        return self.unknown(dataset)

    @property
    def n_terms(self) -> int:
        """Return the number of joints."""
        return len(self.joints)

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return the compliance of some joints only."""
        joints = tuple(self.joints[i] for i in sorted(chosen))
        return replace(self, joints=joints, coefficients=np.zeros(len(joints)))

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the joints of both."""
        if not isinstance(other, KnownTorques) or type(other) is not type(self):
            return None
        joints = tuple(sorted({*self.joints, *other.joints}))
        return replace(self, joints=joints, coefficients=np.zeros(len(joints))).with_coefficients_of(self)

    @property
    def label(self) -> str:
        """The name: all joints' compliance is one effect."""
        return self.name

    def same_place(self, other: Effect) -> bool:
        """Return whether the other is the same kind, at whatever joints."""
        return type(other) is type(self)

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the deflection of every joint over the torque on it."""
        return [self._over_torque(view, k) for k in range(len(self.joints))]

    def _over_torque(self, view: View, k: int) -> Profile:
        """Return the picture of the deflection of the k-th of the joints, k from 0, over its torque [N m]."""
        joint = self.joints[k]
        torque = self.torques(view.nominal, view.poses)[:, joint - 1]
        ends = np.array([float(torque.min()), float(torque.max())])
        curve = np.stack([ends, ends * self.coefficients[k], np.zeros(2)])
        axis = Axis(f"{self.torque_words} joint {joint}", "N m")
        return joint_profile(view, self, joint, axis, torque, curve=curve)
