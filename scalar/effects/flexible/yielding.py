"""Joints that give way under the weight of the arm, one of them not in proportion to the torque on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.bent_deflection import BentDeflection
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.gravity import AXES, torque_about, unit_moments_at
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class UnattributedYielding(BentDeflection):
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
        B[:, self.joint - 1, -1] = self.up_to_knee(self._deflection(B))
        return B

    def torque(self, robot: Robot, poses: Poses) -> Array:
        """Return the deflection by the compliance ``(N,)`` [rad], which is in proportion to the torque."""
        return self._deflection(self.joint_basis(robot, poses))

    def _deflection(self, B: Array) -> Array:
        """Return the joint's deflection ``(N,)`` [rad] by the compliance, from the torques of unit first moments."""
        return B[:, self.joint - 1, :-1] @ np.array(self.weights)

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
    return [
        rival
        for joint in sorted({joint for joint, _ in terms})
        for rival in UnattributedYielding(joint, tuple(terms), tuple(map(float, weights)), 1.0).at_knees(
            dataset
        )
    ]
