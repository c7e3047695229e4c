"""A joint whose axis wobbles as it turns: the track of its bearing is tilted or not round."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.places import LinkEffect
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array

ORDERS = (1, 2)  # periods in a turn of the joint
_DIRECTIONS = ("alpha", "beta")  # the axis tilts about x of the frame before it, and about y


@dataclass(frozen=True, eq=False)
class UnattributedWobble(Unattributed, LinkEffect):
    """The axis of a joint tilts to and fro by a few seconds of arc, a whole number of times in a turn of the joint.

    It is the rival of couplings and of errors of the joints next to it: over a part of a turn, an axis that tilts steadily moves what it bears as
    if the next joint were dragged along. A change of all of the link's geometry (``UnattributedLink``) describes it as well, with many more
    coefficients.

    Attributes:
        joint: From 1.
        order: Periods in a turn.
    """

    joint: int
    order: int

    place: ClassVar[str] = "wobble"

    @property
    def depends_on(self) -> list[str]:
        """Return the joint's own angle."""
        return [f"q{self.joint}"]

    @property
    def described_as(self) -> str:
        """Return which axis wobbles."""
        times = {1: "once", 2: "twice"}.get(self.order, f"{self.order} times")
        return f"a wobble of the axis of joint {self.joint}, {times} in a turn"

    @property
    def key(self) -> str:
        """Name, joint and order."""
        return f"{NAME}_wobble{self.joint}_order{self.order}"

    @property
    def coefficient_names(self) -> list[str]:
        """Sine and cosine of the tilt in each of two directions."""
        return [f"{kind}_{f}_rad" for kind in _DIRECTIONS for f in ("sin", "cos")]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * len(self.coefficient_names)

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return sine and cosine of the joint's angle, ``order`` times, as tilts about the axes x and y of its frame before it turns."""
        angle = self.order * poses.q[:, self.joint - 1]
        waves = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(self.coefficient_names)))
        for k, kind in enumerate(_DIRECTIONS):
            basis[:, GEOMETRY.index(kind), self.joint - 1, 2 * k : 2 * k + 2] = waves
        return basis

    @property
    def advice(self) -> list[str]:
        """Return that the bearing should be looked at."""
        return [
            f"Have the bearing of joint {self.joint} checked: its axis does not keep its direction while the joint turns."
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and order."""
        return {"place": self.place, "joint": self.joint, "order": self.order}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), int(mapping["order"]))


def wobbles_of(joints: Iterable[int]) -> list[UnattributedWobble]:
    """Return the wobbles of the axes of some joints that turn, from 1, with every order that is tried."""
    return [UnattributedWobble(joint, order) for joint in joints for order in ORDERS]
