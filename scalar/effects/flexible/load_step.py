"""Joints that give way by another amount from some pose on: a load that the flange carried from there on, or carried before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import turning_joints
from scalar.effects.flexible.step import UnattributedStep
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.gravity import torques_at_flange
from scalar.effects.places import JointEffect
from scalar.effects.title import joints_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects.flexible.variable import Variable

_STILL = 1e-3  # m: a lever that varies by less shows no load
_MOST_LOADED = 2  # joints with the longest levers, which are also tried without the others


@dataclass(frozen=True, eq=False)
class UnattributedLoadStep(UnattributedStep, JointEffect):
    """Joints err in proportion to the torque of a weight at the flange, from a pose on.

    It is the rival of a tracker or a sensor that was knocked: an arm that takes up a load without a record of it sags, at most poses downwards.
    Each joint has one coefficient: the error for each metre of lever of a weight at the flange.
    """

    place: ClassVar[str] = "load step"

    @property
    def key(self) -> str:
        """Name, joints and place."""
        return f"{NAME}_load_step_{'_'.join(map(str, self.joints))}_{self.at:.3f}"

    @property
    def coefficient_names(self) -> list[str]:
        """The error of each joint for each metre of lever."""
        return [f"joint{j}_rad" for j in self.joints]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians, for a lever of one metre."""
        return ["rad"] * len(self.joints)

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the lever [m] of a weight at the flange about each joint, after the step."""
        levers = _levers_at(robot, poses) * self.since(poses)[:, None]
        B = np.zeros((*levers.shape, len(self.joints)))
        for k, joint in enumerate(self.joints):
            B[:, joint - 1, k] = levers[:, joint - 1]
        return B

    @property
    def described_as(self) -> str:
        """Return which joints give way, and from which pose on."""
        return f"{joints_in_words(self.joints)} giving way by another amount from about order {self.first_order} on, as under another load"

    @property
    def advice(self) -> list[str]:
        """Return that the load should be recorded."""
        return [
            f"Check whether the flange carried something else near order {self.first_order} (a part, a tool). If so, record it in poses.csv: the "
            "column payload [kg], 0 where there was none."
        ]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the step belongs to one campaign."""
        return "the load changed in the course of one campaign"


@lru_cache(maxsize=1)
def _levers_at(robot: Robot, poses: Poses) -> Array:
    """Return the ``levers_at_flange`` of an arm at poses, read-only; the latest are kept, since all steps share them."""
    found = levers_at_flange(robot, poses.q)
    found.setflags(write=False)
    return found


def levers_at_flange(robot: Robot, q: Array) -> Array:
    """Return the horizontal lever of a weight at the flange about each joint's axis ``(N, n)`` [m], with its sign; zero about a joint that slides.

    Args:
        robot: Nominal.
        q: ``(N, n)`` [rad, m].
    """
    levers = torques_at_flange(robot, q, np.zeros(3), robot.down)
    levers[:, list(robot.prismatic)] = 0.0
    return levers


def load_steps(dataset: Dataset, clock: Variable, places: Sequence[float]) -> list[UnattributedLoadStep]:
    """Return steps of the load at each of some places of the clock: of all joints that bear it, and of the few that bear most of it."""
    levers = np.ptp(levers_at_flange(dataset.robot, dataset.q), axis=0)
    loaded = [j for j in turning_joints(dataset) if levers[j - 1] > _STILL]
    most = sorted(sorted(loaded, key=lambda j: -levers[j - 1])[:_MOST_LOADED])
    groups = dict.fromkeys((tuple(loaded), tuple(most)))
    return [UnattributedLoadStep(joints, clock, at) for at in places for joints in groups if joints]
