"""What changes at one moment of a campaign and then stays: the base of flexible terms for the arm, and for its load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import order_and_time
from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.flexible.variable import Variable
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

PLACES = 24  # places in a campaign at which a step is tried first


@dataclass(frozen=True, eq=False)
class UnattributedStep(Unattributed):
    """Something of some joints that is different from a pose on.

    Attributes:
        joints: From 1.
        clock: The order of acquisition.
        at: Place of the step, in units of half the measured range of the order.
    """

    joints: tuple[int, ...]
    clock: Variable
    at: float

    @property
    def depends_on(self) -> list[str]:
        """Return the order of acquisition."""
        return [self.clock.name]

    def since(self, poses: Poses) -> Array:
        """Return at which poses the step has happened ``(N,)``."""
        return self.clock.unit(poses) >= self.at

    def variations(self, scale: float) -> list[Self]:
        """Return a step a little earlier and later."""
        shift = scale / PLACES
        places = [float(np.clip(self.at + a * shift, -1, 1)) for a in (-1.0, -0.5, 0.0, 0.5, 1.0)]
        return [replace(self, at=at) for at in places]

    @property
    def first_order(self) -> str:
        """Return the order of the first pose after the step."""
        return f"{np.ceil(self.clock.centre + self.at * self.clock.half):.0f}"

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
