"""A joint that is dragged along by another, as in wrist gears."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from scalar.data.poses import Poses
from scalar.effects.acquisition import turning_joints
from scalar.effects.command_words import turning_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.angle_sum import sums_with
from scalar.effects.flexible.wobble import wobbles_of
from scalar.effects.joint_pictures import along_joint
from scalar.effects.picture import Map, Profile, View
from scalar.effects.places import SingleJointEffect
from scalar.effects.wording import number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class JointCoupling(SingleJointEffect):
    """One joint's angle leaks into another's: ``dq_j = c q_source``.

    Attributes:
        joint: The joint that errs, from 1.
        source: The joint whose angle leaks into it, from 1.
    """

    joint: int
    source: int

    name: ClassVar[str] = "joint_coupling"
    imitators_are_as_likely: ClassVar[bool] = True
    usual_odds: ClassVar[float] = 8.0  # wrong in 3 of 4 with less, in 0 of 799 with more
    kind: ClassVar[str] = "coupling"
    sentence: ClassVar[str] = (
        "when one joint turns, another turns a little as well, as in wrists whose gears are coupled"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad/rad": 1e-3}
    natural_source: ClassVar[str] = (
        "assumed: a coupling ratio that is rounded to three digits; no data sheet states it"
    )
    most_words: ClassVar[int] = 2

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

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the source's angle as an error of the joint."""
        return poses.q[:, self.source - 1, None]

    def to_mapping(self) -> dict[str, Any]:
        """Return joint and source."""
        return {"joint": self.joint, "source": self.source}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(int(mapping["joint"]), int(mapping["source"]))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the coupling of every pair of joints that turn."""
        moving = turning_joints(dataset)
        return [cls(j, s) for j in moving for s in moving if s != j]

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return all candidates."""
        return cls.candidates(dataset)

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the coupling of the joint and the source that are named."""
        if len(words) < 2:
            raise ValueError("name the joint and its source, as in joint_coupling:6:5")
        joint, source = turning_named(dataset, words[:1])[0], turning_named(dataset, words[1:])[0]
        if joint == source:
            raise ValueError(f"a joint that errs with its own angle is joint_scale:{joint}")
        return [cls(joint, source)]

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return smooth errors of the joint with sums and differences of its source's angle and another's, and wobbles of the source's axis."""
        return [*sums_with(dataset, self.joint, self.source), *wobbles_of([self.source])]

    @property
    def clause(self) -> str:
        """Return which joint is dragged along by which."""
        return f"joint {self.joint} is dragged along by joint {self.source}"

    @property
    def advice(self) -> list[str]:
        """Return where to correct it."""
        return [
            f"Compare the coupling of joint {self.joint} to joint {self.source} in the controller with the arm's data sheet, and correct it there."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, turn joint {self.source} alone from one end of its range to the other, and measure by how much the link of joint "
            f"{self.joint} has turned meanwhile."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            f"For each degree of joint {self.source}, joint {self.joint} turns by {number(float(self.coefficients[0]), 2)}° that the "
            "controller does not count: change its factor of coupling by that."
        )

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over the angle of its source."""
        return [along_joint(view, self, self.joint, self.source)]
