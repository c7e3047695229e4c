"""The geometry of one link, or of the whole arm, that differs from some pose on: after a collision, or where two arms stand in one file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.step import UnattributedStep
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.places import LinkEffect
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects.flexible.variable import Variable

KINDS = ("a", "alpha", "d", "theta")

_ROWS = [GEOMETRY.index(kind) for kind in KINDS]


@dataclass(frozen=True, eq=False)
class UnattributedArmStep(UnattributedStep, LinkEffect):
    """The four DH parameters of some joints are others from a pose on.

    It is the rival of a tracker or a sensor that was knocked, and of warmth: a crash that bends a link would be called one of these.
    """

    place: ClassVar[str] = "arm step"

    @property
    def key(self) -> str:
        """Name, joints and place."""
        return f"{NAME}_arm_step_{'_'.join(map(str, self.joints))}_{self.at:.3f}"

    @property
    def coefficient_names(self) -> list[str]:
        """The change of each parameter of each joint."""
        return [f"joint{j}_{kind}_{'m' if kind in LENGTHS else 'rad'}" for j in self.joints for kind in KINDS]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m" if kind in LENGTHS else "rad" for _ in self.joints for kind in KINDS]

    def constant_and_shares(self, poses: Poses) -> tuple[UnattributedArmStep, Array]:
        """Return the step at the first pose, and one after this step and zero before it."""
        return replace(self, at=-1.0), self.since(poses).astype(float)

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return one for each parameter after the step, and zero before it."""
        after = self.since(poses).astype(float)
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(self.coefficient_names)))
        for i, joint in enumerate(self.joints):
            for j, row in enumerate(_ROWS):
                basis[:, row, joint - 1, i * len(_ROWS) + j] = after
        return basis

    @property
    def described_as(self) -> str:
        """Return which link is another one, and from which pose on."""
        return f"a change of {self._what} from about order {self.first_order} on"

    @property
    def _what(self) -> str:
        if len(self.joints) != 1:
            return "the geometry of the whole arm"
        return f"the link before joint {self.joints[0]}, or of the zero of this joint,"

    @property
    def advice(self) -> list[str]:
        """Return that the two parts of the campaign should be looked at as two arms."""
        look = (
            "Check whether these poses come from two arms"
            if len(self.joints) > 1
            else "Check whether the arm hit something or a bolt gave way"
        )
        return [
            f"{look} near order {self.first_order}. Make two datasets, of the poses before and after it, calibrate each, and see with "
            "'scalar compare' what has changed."
        ]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the step belongs to one campaign."""
        return "the arm changed in the course of one campaign"


def link_steps(dataset: Dataset, clock: Variable, places: Sequence[float]) -> list[UnattributedArmStep]:
    """Return steps of each link at each of some places of the clock, in units of half its measured range."""
    joints = range(1, dataset.robot.n_joints + 1)
    return [UnattributedArmStep((j,), clock, at) for at in places for j in joints]


def whole_arm_steps(dataset: Dataset, clock: Variable, places: Sequence[float]) -> list[UnattributedArmStep]:
    """Return steps of the geometry of all links together at each of some places of the clock, in units of half its measured range."""
    every = tuple(range(1, dataset.robot.n_joints + 1))
    return [UnattributedArmStep(every, clock, at) for at in places]
