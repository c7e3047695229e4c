"""Joints that give way under the weight of the arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.command_words import all_turning_named
from scalar.effects.effect import WEIGHT, Effect
from scalar.effects.flexible.angle_sum import sums_with
from scalar.effects.flexible.yielding import yielding_rivals
from scalar.effects.gravity import AXES, torque_about, unit_moments_at
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import JointEffect
from scalar.effects.title import joints_in_words
from scalar.effects.typical_weight import joints_along_weight
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class JointCompliance(JointEffect):
    """Joints give way under the weight of the arm: ``dq_j = sum over frames of c . (torque of a unit first moment)``.

    Attributes:
        terms: (joint, frame) pairs, from 1: the frame's first moment of mass acts on the joint. Two coefficients a pair.
    """

    terms: tuple[tuple[int, int], ...]

    name: ClassVar[str] = "joint_compliance"
    load: ClassVar[str] = WEIGHT
    kind: ClassVar[str] = "compliance"
    most_words: ClassVar[int] = 100  # as many joints as an arm may have
    sentence: ClassVar[str] = "the joints give way under the weight of the arm"
    natural: ClassVar[Mapping[str, float]] = {"rad": 1e-3}
    natural_source: ClassVar[str] = (
        "a gear of 49 N m per arc minute (Nabtesco RV-20E, catalogue) under 150 N m: 9e-4 rad"
    )

    @property
    def target(self) -> dict[str, Any]:
        """The joints that give way."""
        return {"joints": sorted({joint for joint, _ in self.terms})}

    @property
    def own_weight_joints(self) -> frozenset[int]:
        """The joints, if every term is the weight of a joint's own link."""
        alone = all(joint == frame for joint, frame in self.terms)
        return frozenset(joint for joint, _ in self.terms) if alone else frozenset()

    @property
    def coefficient_names(self) -> list[str]:
        """``joint2_frame3_x_rad``: deflection of joint 2 at full leverage of a first moment of mass along x of frame 3."""
        return [f"joint{j}_frame{f}_{axis}_rad" for j, f in self.terms for axis in AXES]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.terms))

    @property
    def plausible_std(self) -> Array:
        """Return the natural sizes: two effects of the same weight that almost cancel at the measured poses would add up at others."""
        return self.natural_sizes

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the torques of unit first moments, each on its joint."""
        B = np.zeros((len(poses), robot.n_joints, 2 * len(self.terms)))
        moments, axes = unit_moments_at(robot, poses)
        for k, (joint, frame) in enumerate(self.terms):
            B[:, joint - 1, 2 * k : 2 * k + 2] = torque_about(moments, axes, joint, frame)
        return B

    def along_typical_weight(self, robot: Robot, poses: Poses) -> float | None:
        """Return how well the joints' deflections follow the torques of typical masses."""
        deflections = self.joint_basis(robot, poses) @ self.coefficients
        return joints_along_weight(
            robot, poses.q, {joint: deflections[:, joint - 1] for joint in self.target["joints"]}
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the terms."""
        return {"terms": [list(term) for term in self.terms]}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple((int(j), int(f)) for j, f in mapping["terms"]))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the compliance of every revolute joint, and that of all of them together; a joint that stands still gives way as well.

        A joint may move no link whose leverage changes; what then acts on it is constant, and a part of its zero.
        """
        n = dataset.robot.n_joints
        joints = dataset.robot.turning
        pairs = [(j, f) for j in joints for f in range(j, n + 1)]
        alone: list[Effect] = [cls(tuple(p for p in pairs if p[0] == j)) for j in joints]
        return [*alone, cls(tuple(pairs))] if pairs else []

    @classmethod
    def in_every_arm(cls, dataset: Dataset) -> list[Effect]:
        """Return the compliance of all joints together: no gear is rigid."""
        return cls.candidates(dataset)[-1:]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the compliance of the joints that are named, or of all joints, as one effect."""
        n = dataset.robot.n_joints
        return [cls(tuple((j, f) for j in all_turning_named(dataset, words) for f in range(j, n + 1)))]

    @property
    def n_terms(self) -> int:
        """Return the number of pairs."""
        return len(self.terms)

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return the compliance of some pairs only."""
        return JointCompliance(tuple(self.terms[i] for i in sorted(chosen)))

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the pairs of both: all joints carry the same arm."""
        if not isinstance(other, JointCompliance):
            return None
        return JointCompliance(tuple(sorted({*self.terms, *other.terms}))).with_coefficients_of(self)

    @property
    def label(self) -> str:
        """The name: all joints' compliance is one effect."""
        return self.name

    def same_place(self, other: Effect) -> bool:
        """Return whether the other is a compliance of joints as well."""
        return isinstance(other, JointCompliance)

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return what a deflection by the weight may be instead.

        The torque on a joint varies with sums of angles, so a smooth error with such a sum, as of a parallel link or a hose, imitates it. Once the
        compliance has been fitted, changes of the stiffness of each joint at a torque are tried as well: gears are softer under small torques.
        """
        sums = [rival for joint in self.target["joints"] for rival in sums_with(dataset, joint, joint)]
        if not self.coefficients.any():
            return list(sums)
        return [*yielding_rivals(dataset, self.terms, self.coefficients), *sums]

    @property
    def clause(self) -> str:
        """Return which joints give way."""
        joints = self.target["joints"]
        return (
            f"{joints_in_words(joints)} give{'' if len(joints) > 1 else 's'} way under the weight of the arm"
        )

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Give the controller the true payload, and keep it as it was in this campaign: under a heavier load the joints give way by more."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            "To see it directly, hang a known weight on the flange of the stretched arm, with a dial gauge next to it, and compare the readings with "
            "and without the weight."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            "Where the controller compensates for gravity or for the stiffness of its gears, let it do so with the true payload, and calibrate "
            "again."
        )

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the deflection of every joint over the torque on it."""
        return [self._over_torque(view, joint) for joint in self.target["joints"]]

    def _over_torque(self, view: View, joint: int) -> Profile:
        """Return the picture of the deflection of a joint, from 1, over its gravity torque relative to the largest."""
        fitted = (self.joint_basis(view.nominal, view.poses) @ self.coefficients)[:, joint - 1]
        largest = max(float(np.max(np.abs(fitted))), 1e-300)
        # The deflection is the torque divided by the stiffness, which is not known separately.
        axis = Axis(f"gravity torque on joint {joint}, relative to the largest", "1")
        ends = np.array([float(fitted.min()), float(fitted.max())])
        curve = np.stack([ends / largest, ends, np.zeros(2)])
        note = (
            "The torque's shape is fitted too, since the masses of the links are not known. So no stiffness in N m/rad follows: that needs the "
            "joints' torques, or a payload that differs from pose to pose, recorded in poses.csv."
        )
        return joint_profile(view, self, joint, axis, fitted / largest, curve=curve, note=note)
