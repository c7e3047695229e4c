"""A joint that gives way up to some torque of the arm's weight, and no further."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from scalar.data.poses import Poses
from scalar.effects.flexible.bent_deflection import BentDeflection
from scalar.effects.flexible.unattributed import NAME
from scalar.effects.gravity import assumed_torque
from scalar.effects.places import SingleJointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class UnattributedWindUp(BentDeflection, SingleJointEffect):
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
        """Return the torque by ``masses``."""
        return assumed_torque(robot, poses.q, self.joint, self.masses)

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the torque over that at the knee, limited to -1 and 1."""
        return self.up_to_knee(self.torque(robot, poses))[:, None]

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
    return UnattributedWindUp(joint, 1.0, tuple(masses)).at_knees(dataset)
