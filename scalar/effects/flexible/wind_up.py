"""A joint that gives way up to some torque of the arm's weight, and no further."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import GRAVITY
from scalar.effects.flexible.yielding import KNEES
from scalar.effects.gravity import assumed_torque
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import SingleJointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class UnattributedWindUp(Unattributed, SingleJointEffect):
    """A joint's gear is wound up in proportion to the torque on it up to a torque, and no further: ``dq_j = b clip(torque / knee, -1, 1)``.

    It is the rival of a play whose side follows from the torque: that changes its side at once where the torque changes its sign. Together with
    a compliance it is a gear that is softer under small torques.

    Attributes:
        joint: From 1.
        knee: Torque up to which it gives way, greater than 0, in the unit of ``assumed_torque``.
        masses: First moments of mass as for ``assumed_torque``; empty for those of a typical arm.
    """

    joint: int
    knee: float
    masses: tuple[float, ...] = ()

    place: ClassVar[str] = "wind_up"

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
        return f"{NAME}_wind_up{self.joint}_{self.knee:.3g}"

    @property
    def coefficient_names(self) -> list[str]:
        """The largest deflection."""
        return ["wound_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"]

    def torque(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque on the joint over that at the knee ``(N,)``."""
        return assumed_torque(robot, poses.q, self.joint, self.masses) / self.knee

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque over that at the knee, limited to -1 and 1."""
        return np.clip(self.torque(robot, poses), -1.0, 1.0)[:, None]

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the deflection of the joint over the torque on it."""
        torque = self.torque(view.nominal, view.poses)
        largest = max(float(np.max(np.abs(torque))), 1e-300)
        axis = Axis(f"gravity torque on joint {self.joint}, relative to the largest", "1")
        return [joint_profile(view, self, self.joint, axis, torque / largest)]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, knee and masses."""
        return {"place": self.place, "joint": self.joint, "knee": self.knee, "masses": list(self.masses)}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), float(mapping["knee"]), tuple(float(m) for m in mapping["masses"]))


def wind_ups(dataset: Dataset, joint: int, masses: Sequence[float] = ()) -> list[UnattributedWindUp]:
    """Return the wind-ups of a joint to some torques.

    Args:
        dataset: On which it acts.
        joint: From 1. It turns, and the weight exerts a torque on it.
        masses: As for ``UnattributedWindUp``.

    Returns:
        One for each of ``KNEES``, which are shares of the largest torque in the dataset; none if there is no torque.
    """
    poses = Poses.of_joints(dataset.q)
    whole = UnattributedWindUp(joint, 1.0, tuple(masses))
    largest = float(np.max(np.abs(whole.torque(dataset.robot, poses))))
    if largest == 0.0:
        return []
    return [replace(whole, knee=share * largest) for share in KNEES]
