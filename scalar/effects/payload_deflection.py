"""Joints that give way under a payload on the flange."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.formats import PAYLOAD
from scalar.data.poses import Poses
from scalar.effects.acquisition import missing_column
from scalar.effects.gravity import torques_at_flange
from scalar.effects.stiffness import KnownTorques
from scalar.effects.title import joints_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_SAME = 1e-3  # kg; payloads that differ by less count as equal


@dataclass(frozen=True, eq=False)
class PayloadDeflection(KnownTorques):
    """Joints give way under the torque of the payload's weight, ``dq_j = s_j z_j . ((p - o_j) x m g)``.

    p is the payload's centre of mass, z_j the direction of axis j and o_j a point on it. The mass m is the column ``payload`` [kg], and p is given by
    ``payload_x, payload_y, payload_z`` [m] in the flange's frame; without these columns it is the flange's origin.
    """

    name: ClassVar[str] = "payload_deflection"
    kind: ClassVar[str] = "deflection by the payload"
    sentence: ClassVar[str] = "the joints give way under the payload"
    torque_words: ClassVar[str] = "torque of the payload on"

    def torques(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque of the payload about every joint."""
        mass, none = poses.column(PAYLOAD[0]), np.zeros(len(poses))
        place = np.stack([poses.columns.get(name, none) for name in PAYLOAD[1:]], axis=1)
        return mass[:, None] * torques_at_flange(robot, poses.q, place, robot.gravity)

    @classmethod
    def unknown(cls, dataset: Dataset) -> str | None:
        """Return that the payload is not recorded, or is always the same, or None."""
        missing = missing_column(dataset, PAYLOAD[0])
        if missing is None and float(np.ptp(dataset.poses[PAYLOAD[0]].to_numpy(dtype=float))) < _SAME:
            return "the payload is the same at all poses, so that its deflection is that of the arm's own weight: use joint_compliance"
        return missing

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the payload is not recorded; unlike in ``unknown``, a constant payload will do, because it deflects the joints too."""
        return missing_column(dataset, PAYLOAD[0])

    @property
    def follows(self) -> tuple[str, ...]:
        """The payload."""
        return ("payload",)

    @property
    def clause(self) -> str:
        """Return which joints give way."""
        return (
            f"{joints_in_words(self.joints)} give{'' if len(self.joints) > 1 else 's'} way under the payload"
        )

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Give the payload and where it sits for each program that is corrected: the arm gives way by as much as it carries."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return "To see it directly, measure a stretched pose with and without the payload, with a dial gauge at the flange."

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "Where the controller compensates for the stiffness of its gears, tell it the true payload of each program."
