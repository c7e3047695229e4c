"""What deflections of a joint have in common whose slope over the torque on it changes at some torque, the knee."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.flexible.variable import GRAVITY
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import JointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

KNEES = (0.15, 0.3, 0.5)  # shares of the largest torque at which the slope is tried to change


class BentDeflection(Unattributed, JointEffect):
    """A joint gives way under the weight of the arm, but not in proportion to the torque on it; subclasses are dataclasses with these fields.

    Attributes:
        joint: From 1.
        knee: The torque at which the slope changes, greater than 0, in the unit of ``torque``.
    """

    joint: int
    knee: float

    @abstractmethod
    def torque(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque on the joint ``(N,)``, in any unit."""

    @property
    def depends_on(self) -> list[str]:
        """Return gravity and the joint's angle."""
        return [GRAVITY, f"q{self.joint}"]

    @property
    def described_as(self) -> str:
        """Return which joint gives way, and how."""
        return f"a deflection of joint {self.joint} under the weight of the arm that is not in proportion to the torque on it"

    def up_to_knee(self, torque: Array) -> Array:
        """Return torques ``(N,)`` over that at the knee, limited to -1 and 1."""
        return np.clip(torque / self.knee, -1.0, 1.0)

    def at_knees(self, dataset: Dataset) -> list[Self]:
        """Return this deflection with each of ``KNEES``, shares of the largest torque in a dataset; none if there is no torque."""
        largest = float(np.max(np.abs(self.torque(dataset.robot, Poses.of_joints(dataset.q)))))
        return [replace(self, knee=share * largest) for share in KNEES] if largest > 0 else []  # type: ignore[type-var]

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the deflection of the joint over the torque on it."""
        torque = self.torque(view.nominal, view.poses)
        largest = max(float(np.max(np.abs(torque))), 1e-300)
        axis = Axis(f"gravity torque on joint {self.joint}, relative to the largest", "1")
        return [joint_profile(view, self, self.joint, axis, torque / largest)]
