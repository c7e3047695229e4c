"""The geometry of one link, or of the whole arm, that differs from some pose on: after a collision, or where two arms stand in one file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import order_and_time
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import Variable
from scalar.effects.places import LinkEffect
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

KINDS = ("a", "alpha", "d", "theta")
PLACES = 24  # places in a campaign at which a step is tried first

_ROWS = [GEOMETRY.index(kind) for kind in KINDS]


@dataclass(frozen=True, eq=False)
class UnattributedArmStep(Unattributed, LinkEffect):
    """The four DH parameters of some joints are others from a pose on.

    It is the rival of a tracker or a sensor that was knocked, and of warmth: a crash that bends a link would be called one of these.

    Attributes:
        joints: From 1.
        clock: The order of acquisition.
        at: Place of the step, in units of half the measured range of the order.
    """

    joints: tuple[int, ...]
    clock: Variable
    at: float

    place: ClassVar[str] = "arm step"

    @property
    def depends_on(self) -> list[str]:
        """Return the order of acquisition."""
        return [self.clock.name]

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

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return one for each parameter after the step, and zero before it."""
        after = self.since(poses).astype(float)
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(self.coefficient_names)))
        for i, joint in enumerate(self.joints):
            for j, row in enumerate(_ROWS):
                basis[:, row, joint - 1, i * len(_ROWS) + j] = after
        return basis

    def since(self, poses: Poses) -> Array:
        """Return at which poses the arm has changed ``(N,)``."""
        return self.clock.unit(poses) >= self.at

    def variations(self, scale: float) -> list[Self]:
        """Return a step a little earlier and later."""
        return [replace(self, at=at) for at in places_of_steps(self.at, scale)]

    @property
    def described_as(self) -> str:
        """Return which link is another one, and from which pose on."""
        return f"a change of {self._what} from about order {self._order:.0f} on"

    @property
    def _order(self) -> float:
        return float(np.ceil(self.clock.centre + self.at * self.clock.half))

    @property
    def _what(self) -> str:
        if len(self.joints) > 1:
            return "the geometry of the whole arm"
        (joint,) = self.joints
        return f"the link before joint {joint}, or of the zero of this joint,"

    @property
    def advice(self) -> list[str]:
        """Return that the two parts of the campaign should be looked at as two arms."""
        look = (
            "Look whether these poses come from two arms"
            if len(self.joints) > 1
            else "Look whether the arm hit something or a bolt gave way"
        )
        return [
            f"{look} near order {self._order:.0f}. Make two datasets, of the poses before and after it, calibrate each, and see with "
            "'scalar compare' what has changed."
        ]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the step belongs to one campaign."""
        return "the arm changed in the course of one campaign"

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joints, clock and when."""
        return {
            "place": self.place,
            "joints": list(self.joints),
            "clock": self.clock.to_mapping(),
            "at": self.at,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        joints = tuple(int(j) for j in mapping["joints"])
        return cls(joints, Variable.from_mapping(mapping["clock"]), float(mapping["at"]))


def places_of_steps(at: float, scale: float) -> list[float]:
    """Return a place, and places a little earlier and later, in units of half the measured range."""
    shift = scale / PLACES
    return [float(np.clip(at + a * shift, -1, 1)) for a in (-1.0, -0.5, 0.0, 0.5, 1.0)]


def clock_of_steps(dataset: Dataset, order: float | None) -> tuple[Variable, list[float]]:
    """Return the order of acquisition as a variable, and the places of steps in it.

    Args:
        dataset: On which they act.
        order: The order of the first pose after the step; None for several places in the campaign.
    """
    clock = Variable.observed("order", order_and_time(dataset)[0])
    if order is None:
        return clock, [float(at) for at in np.linspace(-1, 1, PLACES + 2)[1:-1]]
    return clock, [(order - 0.5 - clock.centre) / clock.half]


def arm_steps(dataset: Dataset, order: float | None = None) -> list[UnattributedArmStep]:
    """Return steps of each link and of the whole arm.

    Args:
        dataset: On which they act.
        order: As for ``clock_of_steps``.
    """
    clock, places = clock_of_steps(dataset, order)
    every = tuple(range(1, dataset.robot.n_joints + 1))
    return [
        UnattributedArmStep(joints, clock, at) for at in places for joints in (*((j,) for j in every), every)
    ]
