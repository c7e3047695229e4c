"""A link's geometry that errs with its joint's angle or with the direction of gravity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import GRAVITY
from scalar.effects.places import LinkEffect
from scalar.effects.wording import columns_in_words
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array

WOBBLE_ORDERS = (1, 2, 3)  # periods in a turn of the joint


@dataclass(frozen=True, eq=False)
class UnattributedLink(Unattributed, LinkEffect):
    """A link's geometry errs with its joint's own angle (an axis that wobbles) or with the direction of gravity (a link that bends).

    Attributes:
        joint: From 1.
        by: ``q<joint>`` or ``gravity``.
    """

    joint: int
    by: str

    place: ClassVar[str] = "link"

    @property
    def depends_on(self) -> list[str]:
        """Return what drives the error: a joint's angle, or gravity."""
        return [self.by]

    @property
    def described_as(self) -> str:
        """Return that it is a change of the link's geometry, and what it varies with."""
        return f"a change of the geometry of link {self.joint} with {columns_in_words([self.by])}"

    @property
    def key(self) -> str:
        """Name, joint and driver."""
        return f"{NAME}_link{self.joint}_{self.by}"

    @property
    def _functions(self) -> list[str]:
        if self.by == GRAVITY:
            return ["gx", "gy", "gz"]
        return [f"{f}{k}" for k in WOBBLE_ORDERS for f in ("sin", "cos")]

    @property
    def coefficient_names(self) -> list[str]:
        """Every function for every kind of geometry."""
        return [
            f"{kind}_{f}_{'m' if kind in LENGTHS else 'rad'}" for kind in GEOMETRY for f in self._functions
        ]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m" if kind in LENGTHS else "rad" for kind in GEOMETRY for _ in self._functions]

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions at every kind of geometry of the joint."""
        if self.by == GRAVITY:
            functions = np.einsum("nij,i->nj", robot.frames(poses.q)[:, self.joint - 1, :3, :3], robot.down)
        else:
            q = poses.q[:, self.joint - 1]
            functions = np.stack([f(k * q) for k in WOBBLE_ORDERS for f in (np.sin, np.cos)], axis=1)
        w = functions.shape[1]
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(GEOMETRY) * w))
        for k in range(len(GEOMETRY)):
            basis[:, k, self.joint - 1, k * w : (k + 1) * w] = functions
        return basis

    @property
    def advice(self) -> list[str]:
        """Return what to look at on the link."""
        if self.by == GRAVITY:
            return [
                f"Check the bolts and the bearing of the link at joint {self.joint}: its error varies with the direction of gravity."
            ]
        return [
            f"Have the bearing of joint {self.joint} checked, or its guide if it slides: its axis is not the same at all of its positions."
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and driver."""
        return {"place": self.place, "joint": self.joint, "by": self.by}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), str(mapping["by"]))
