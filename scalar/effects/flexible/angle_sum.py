"""A joint's angle that errs smoothly with the sum, or the difference, of two joints' angles."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.polynomial import legendre

from scalar.data.poses import Poses
from scalar.effects.acquisition import turning_joints
from scalar.effects.flexible.joint import SINGLE_DEGREE
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import SingleJointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class UnattributedAngleSum(Unattributed, SingleJointEffect):
    """A joint's angle errs with ``q_a + q_b`` or ``q_a - q_b``: a hose that is wound up by two joints, or a link that is turned by both, acts so.

    It is the rival of couplings, because where a hose pulls hard only near the ends of its travel, each joint seems to be dragged along in
    proportion, and of a joint that gives way, because the torque of its link's weight varies with such a sum.

    Attributes:
        joint: The joint that errs, from 1.
        of: The two joints, from 1.
        sign: 1 for the sum, -1 for the difference.
        centre, half: Of the measured range of the sum [rad].
    """

    joint: int
    of: tuple[int, int]
    sign: int
    centre: float
    half: float

    place: ClassVar[str] = "angle_sum"

    @property
    def depends_on(self) -> list[str]:
        """Return the two joints."""
        return [f"q{j}" for j in self.of]

    @property
    def described_as(self) -> str:
        """Return which joint errs, and with what."""
        return f"an error of the angle of joint {self.joint} that varies smoothly with {self._in_words}"

    @property
    def _in_words(self) -> str:
        return f"the {'sum' if self.sign > 0 else 'difference'} of the positions of joints {self.of[0]} and {self.of[1]}"

    @property
    def key(self) -> str:
        """Name, joint, and the two joints with the sign between them."""
        return f"{NAME}_joint{self.joint}_q{self.of[0]}_{'plus' if self.sign > 0 else 'minus'}_q{self.of[1]}"

    @property
    def coefficient_names(self) -> list[str]:
        """Numbered functions."""
        return [f"f{k + 1}_rad" for k in range(SINGLE_DEGREE)]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * SINGLE_DEGREE

    def values(self, poses: Poses) -> Array:
        """Return the sum or the difference ``(N,)`` [rad]."""
        a, b = (poses.q[:, j - 1] for j in self.of)
        return a + self.sign * b

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return Legendre polynomials of the sum, without the constant."""
        u = np.clip((self.values(poses) - self.centre) / self.half, -1.0, 1.0)
        return legendre.legvander(u, SINGLE_DEGREE)[:, 1:]

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over the sum."""
        axis = Axis(f"q{self.of[0]} {'+' if self.sign > 0 else '−'} q{self.of[1]}", "rad")
        return [joint_profile(view, self, self.joint, axis, self.values(view.poses))]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joints, sign and range."""
        return {
            "place": self.place,
            "joint": self.joint,
            "of": list(self.of),
            "sign": self.sign,
            "centre": self.centre,
            "half": self.half,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        a, b = (int(j) for j in mapping["of"])
        return cls(
            int(mapping["joint"]),
            (a, b),
            int(mapping["sign"]),
            float(mapping["centre"]),
            float(mapping["half"]),
        )


def sums_with(dataset: Dataset, joint: int, source: int) -> list[UnattributedAngleSum]:
    """Return errors of a joint with the sums and differences of a joint's angle and of each other's.

    Args:
        dataset: On which they act.
        joint: The joint that errs, from 1.
        source: The joint that is one of the two, from 1.
    """
    found = []
    for other, sign in itertools.product(turning_joints(dataset), (1, -1)):
        if other != source:
            a, b = sorted((source, other))
            sums = dataset.q[:, a - 1] + sign * dataset.q[:, b - 1]
            seen = Variable.observed("", sums)
            found.append(UnattributedAngleSum(joint, (a, b), sign, seen.centre, seen.half))
    return found
