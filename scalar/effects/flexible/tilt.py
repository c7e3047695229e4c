"""A joint whose axis tilts under the weight that it bears: its bearing gives way, or has play, across the axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import GRAVITY
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.gravity import typical_moment
from scalar.effects.places import LinkEffect
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array, cross

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_TURNED_OVER = 0.06  # of the longest moment: below it, play is crossed gradually


@dataclass(frozen=True, eq=False)
class UnattributedTilt(Unattributed, LinkEffect):
    """The axis of a joint tilts in the direction of the moment of the weight across it, in proportion to it, and by the play of its bearing.

    It is the rival of a base that gives way, and of joints that give way about their axes or have play that is crossed as the load changes sides. The
    masses of the links are not known: one kilogram at the end of each link after the joint is taken. The axis of the first joint tilts with the base,
    whose compliance has a name: of it, only the play is left.

    Attributes:
        joint: From 1.
    """

    joint: int

    place: ClassVar[str] = "tilt"

    @property
    def depends_on(self) -> list[str]:
        """Return the direction of gravity."""
        return [GRAVITY]

    @property
    def key(self) -> str:
        """Name and joint."""
        return f"{NAME}_tilt{self.joint}"

    @property
    def coefficient_names(self) -> list[str]:
        """The tilt at the longest moment that the links could have, except for the first joint, and the half width of the play."""
        return ["elastic_rad", "play_rad"] if self.joint > 1 else ["play_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * len(self.coefficient_names)

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the tilt about the axes x (as alpha) and y (as beta) of the joint's frame before it turns."""
        moments = moments_across(robot, poses.q, self.joint)
        size = np.linalg.norm(moments, axis=1, keepdims=True)
        bound = longest_moment(robot, self.joint)
        tilts = np.stack([moments / bound, moments / (size + _TURNED_OVER * bound)], axis=2)
        tilts = tilts[:, :, 2 - len(self.coefficient_names) :]
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, tilts.shape[2]))
        for axis, kind in enumerate(("alpha", "beta")):
            basis[:, GEOMETRY.index(kind), self.joint - 1] = tilts[:, axis]
        return basis

    @property
    def described_as(self) -> str:
        """Return which axis tilts."""
        if self.joint == 1:
            return "play of the base, or of the bearing of joint 1: it leans to the side of the weight by a fixed angle"
        return f"a tilt of the axis of joint {self.joint} under the weight that it bears"

    @property
    def advice(self) -> list[str]:
        """Return that the bearing should be looked at."""
        if self.joint == 1:
            return [
                "Have the bolts of the base and the bearing of joint 1 checked: it tilts to the side of the weight, by a fixed angle."
            ]
        return [
            f"Have the bearing of joint {self.joint} checked: its axis tilts under the weight that it bears."
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place and joint."""
        return {"place": self.place, "joint": self.joint}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]))


def moments_across(robot: Robot, q: Array, joint: int) -> Array:
    """Return the moment of one kilogram at the end of each link after a joint, across its axis ``(N, 2)``, over the weight [m].

    Args:
        robot: Nominal.
        q: ``(N, n)`` [rad, m].
        joint: From 1.

    Returns:
        The components along x of the frame before the joint, and along y, which with x and the joint's axis is right-handed.
    """
    frames = robot.frames(q)
    moment = typical_moment(robot, frames, joint)
    x, z = frames[:, joint - 1, :3, 0], frames[:, joint, :3, 2]
    return np.stack([np.sum(moment * x, axis=1), np.sum(moment * cross(z, x), axis=1)], axis=1)


def longest_moment(robot: Robot, joint: int) -> float:
    """Return a bound of ``moments_across`` [m], of links that are stretched out: it depends on the arm alone, and not on the poses.

    Args:
        robot: Nominal.
        joint: From 1.
    """
    a, d = (robot.geometry[GEOMETRY.index(kind)] for kind in ("a", "d"))
    flange = float(np.linalg.norm(robot.T_n_flange[:3, 3]))
    ends = np.cumsum([*np.hypot(a, d)[joint:], flange])
    return max(float(ends.sum()), 1e-300)


def tilts(dataset: Dataset, *, with_base: bool = False) -> list[UnattributedTilt]:
    """Return a tilt of every joint that turns but the first of them, whose axis tilts with the base.

    Args:
        dataset: On which they act.
        with_base: Whether to return the play of the base too, where joint 1 turns; it is tried as a rival of named effects alone.
    """
    turning = dataset.robot.turning
    of_base = [UnattributedTilt(1)] if with_base and 1 in turning else []
    return of_base + [UnattributedTilt(j) for j in turning[1:]]
