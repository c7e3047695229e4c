"""Joints that give way under the torque that was measured at them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.formats import TORQUE
from scalar.data.poses import Poses
from scalar.effects.effect import WEIGHT
from scalar.effects.stiffness import KnownTorques
from scalar.effects.title import joints_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class TorqueCompliance(KnownTorques):
    """Joints give way under their own measured torque, ``dq_j = s_j tau_j``; the sign of tau is the controller's, so s may have either sign.

    Unlike ``joint_compliance``, which knows only the arm's own weight, it holds for other payloads, as long as the torques are recorded with them.
    """

    name: ClassVar[str] = "torque_compliance"
    load: ClassVar[str] = WEIGHT
    kind: ClassVar[str] = "compliance by measured torque"
    sentence: ClassVar[str] = "the joints give way in proportion to the torques that were recorded"
    torque_words: ClassVar[str] = "measured torque of"

    def torques(self, robot: Robot, poses: Poses) -> Array:
        """Return the columns tau1..taun."""
        return np.stack([poses.column(f"{TORQUE}{j + 1}") for j in range(robot.n_joints)], axis=1)

    @classmethod
    def unknown(cls, dataset: Dataset) -> str | None:
        """Return that a torque is not recorded, or None."""
        missing = [f"{TORQUE}{j + 1}" for j in range(dataset.robot.n_joints)]
        missing = [name for name in missing if name not in dataset.poses]
        return (
            f"poses.csv has no column '{missing[0]}': the torques of all joints are needed"
            if missing
            else None
        )

    @property
    def clause(self) -> str:
        """Return which joints give way."""
        s = "" if len(self.joints) > 1 else "s"
        return f"{joints_in_words(self.joints)} give{s} way in proportion to the measured torque"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Record the joints' torques where the correction is used, or predict them: the deflection follows them, under any payload."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            "To see it directly, hang a known weight on the flange of the stretched arm, and compare a dial gauge next to it with the change of the "
            "recorded torques."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            "Where the controller compensates for the stiffness of its gears, these are their compliances, in radians for each newton metre of "
            "recorded torque."
        )
