"""Joints that give way under the weight of the arm, one of them not in proportion to the torque on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import GRAVITY
from scalar.effects.gravity import AXES, torque_about, unit_moments_at
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import JointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

KNEES = (0.15, 0.3, 0.5)  # shares of the largest torque at which the stiffness is tried to change


@dataclass(frozen=True, eq=False)
class UnattributedYielding(Unattributed, JointEffect):
    """Joints give way under the weight of the arm, and the stiffness of one of them changes at a torque: below it, the gear is softer or stiffer.

    It is the rival of a compliance, whose deflection is in proportion to the torque. The masses of the links are unknown, so the torque on the joint
    is known only up to a factor. It is stated by the deflection that the compliance which was found gives the joint.

    Attributes:
        joint: The joint whose stiffness changes, from 1.
        terms: (joint, frame) pairs as in ``JointCompliance``.
        weights: ``(2 len(terms),)`` [rad], the coefficients of the compliance; those of the joint's pairs give the shape of its torque.
        knee: [rad], the deflection by that compliance at which the stiffness changes.
    """

    joint: int
    terms: tuple[tuple[int, int], ...]
    weights: tuple[float, ...]
    knee: float

    contains_imitated: ClassVar[bool] = True
    place: ClassVar[str] = "yielding"

    @property
    def erring_joint(self) -> int | None:
        """Return None, as for a compliance: its columns are those of several joints."""
        return None

    @property
    def depends_on(self) -> list[str]:
        """Return gravity and the joint's angle."""
        return [GRAVITY, f"q{self.joint}"]

    @property
    def described_as(self) -> str:
        """Return which joint gives way, and how."""
        return f"a deflection of joint {self.joint} under the weight of the arm that is not in proportion to the torque on it"

    @property
    def key(self) -> str:
        """Name, joint and knee."""
        return f"{NAME}_yielding_joint{self.joint}_{self.knee:.3g}"

    @property
    def coefficient_names(self) -> list[str]:
        """Those of the compliance, and the deflection that is added at the knee."""
        return [*(f"joint{j}_frame{f}_{axis}_rad" for j, f in self.terms for axis in AXES), "knee_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.terms) + 1)

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the torques of unit first moments, each on its joint, and the torque on ``joint`` over that at the knee, limited to -1 and 1."""
        B = np.zeros((len(poses), robot.n_joints, 2 * len(self.terms) + 1))
        moments, axes = unit_moments_at(robot, poses)
        for k, (joint, frame) in enumerate(self.terms):
            B[:, joint - 1, 2 * k : 2 * k + 2] = torque_about(moments, axes, joint, frame)
        B[:, self.joint - 1, -1] = np.clip(self.deflection(B) / self.knee, -1.0, 1.0)
        return B

    def deflection(self, B: Array) -> Array:
        """Return the joint's deflection ``(N,)`` [rad] by the compliance, from the torques of unit first moments."""
        return B[:, self.joint - 1, :-1] @ np.array(self.weights)

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the deflection of the joint over the torque on it."""
        torque = self.deflection(self.joint_basis(view.nominal, view.poses))
        largest = max(float(np.max(np.abs(torque))), 1e-300)
        axis = Axis(f"gravity torque on joint {self.joint}, relative to the largest", "1")
        return [joint_profile(view, self, self.joint, axis, torque / largest)]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, terms, weights and knee."""
        return {
            "place": self.place,
            "joint": self.joint,
            "terms": [list(term) for term in self.terms],
            "weights": list(self.weights),
            "knee": self.knee,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(
            int(mapping["joint"]),
            tuple((int(j), int(f)) for j, f in mapping["terms"]),
            tuple(float(w) for w in mapping["weights"]),
            float(mapping["knee"]),
        )


def yielding_rivals(
    dataset: Dataset, terms: Sequence[tuple[int, int]], weights: Array
) -> list[UnattributedYielding]:
    """Return a change of the stiffness of each joint that gives way, at each of some torques.

    Args:
        dataset: On which they act.
        terms: (joint, frame) pairs of the compliance that was found.
        weights: ``(2 len(terms),)`` [rad], its coefficients.
    """
    found = []
    poses = Poses.of_joints(dataset.q)
    for joint in sorted({joint for joint, _ in terms}):
        whole = UnattributedYielding(joint, tuple(terms), tuple(map(float, weights)), 1.0)
        largest = float(np.max(np.abs(whole.deflection(whole.joint_basis(dataset.robot, poses)))))
        if largest > 0:
            found += [replace(whole, knee=share * largest) for share in KNEES]
    return found
