"""A tilt between near-parallel axes that modified DH parameters cannot hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect
from scalar.effects.picture import Map, Profile
from scalar.effects.places import LinkEffect, OneJoint
from scalar.effects.wording import angle
from scalar.geometry.parallel_axes import near_parallel_joints
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class AxisNonparallel(OneJoint, LinkEffect):
    """The angle about y between near-parallel axes, Hayati's beta, that four DH parameters cannot hold.

    Attributes:
        joint: From 1.
    """

    joint: int

    name: ClassVar[str] = "axis_nonparallel"
    kind: ClassVar[str] = "tilted axis"
    sentence: ClassVar[str] = (
        "the axis is not quite parallel to the one before it, and the tilt is in the direction that DH parameters cannot describe"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad": 2e-3}
    natural_source: ClassVar[str] = (
        "general tolerance of angles between sides of 120 to 400 mm: 10 arc minutes, 2.9e-3 rad (ISO 2768-1, class m)"
    )
    frees: ClassVar[str] = "beta"

    @property
    def coefficient_names(self) -> list[str]:
        """``beta_rad``, on top of the nominal one."""
        return ["beta_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"]

    @property
    def prior_std(self) -> Array:
        """Return 0.05 rad, about three degrees: errors of assembly are larger than those of wear or load."""
        return np.array([0.05])

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return a basis that is one for beta of the joint and zero elsewhere."""
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, 1))
        basis[:, GEOMETRY.index("beta"), self.joint - 1, 0] = 1.0
        return basis

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the tilt of every axis that is near-parallel to the one before."""
        return [cls(j) for j in near_parallel_joints(dataset.robot)]

    @classmethod
    def in_every_arm(cls, dataset: Dataset) -> list[Effect]:
        """Return the tilt of every such axis: none is assembled quite parallel to another."""
        return cls.candidates(dataset)

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the tilt of the axis that is named, or of every one that is near-parallel to the one before."""
        return super().parsed(dataset, words) if words else cls.candidates(dataset)

    @property
    def clause(self) -> str:
        """Return which axis is tilted."""
        return f"the axis of joint {self.joint} is not quite parallel to the axis of joint {self.joint - 1}"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Correct programs with 'scalar correct', or use a controller whose robot model has a further angle for this joint (Hayati's beta, about "
            "y): four DH parameters a joint cannot describe this tilt."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, turn joint {self.joint - 1} alone and then joint {self.joint} alone, each with a tracker's target far "
            "from its axis: the tilt is an angle between the two circles. A joint that slides draws a line: the tilt is the angle between it and the "
            "normal of the other's circle."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            "A controller with plain DH parameters cannot hold this tilt: 'scalar export' writes it to a URDF, and 'scalar correct' applies it to "
            "programs."
        )

    def size(self, pictures: Sequence[Profile | Map]) -> str:
        """Return the angle itself."""
        return angle(abs(float(self.coefficients[0])))
