"""A floor that yields under the arm once the anchors of the base plate lift."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.causes.base import Cause, every_joint
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array, rotation_from_vector, transform
from scalar.simulation.world import World

PRELOAD = (0.4, 0.65)  # the anchors hold the plate down up to this quantile of the scene's moments
SOFTER = (1.0, 3.0)  # compliance in the direction of the floor's soft side, over that elsewhere


@dataclass(frozen=True, eq=False)
class GivingFloor(Cause):
    """The base plate lifts off on one side once the moment M of the arm's weight exceeds the preload M0 of its anchors.

    tilt = compliance max(|M| - M0, 0) M / |M|, where the compliance is larger if the arm leans to the soft side of the floor.
    """

    kind: ClassVar[str] = "giving_floor"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the preload and the soft side."""
        with World() as world:
            world.place_arm(stage.arm)
            moments = world.weight_moments(stage.q, np.zeros(3))
        hold = float(np.quantile(np.linalg.norm(moments, axis=1), rng.uniform(*PRELOAD)))
        soft, side = float(rng.uniform(*SOFTER)), float(rng.uniform(0.0, 2 * np.pi))
        largest = np.linalg.norm(_tilt(moments, hold, soft, side), axis=1).max()
        details = cls.details_of(
            every_joint(stage.arm.n),
            holds_n_m=hold,
            softer=soft,
            soft_side_rad=side,
            factor=float(size / largest),
        )
        return cls({}, size, details)

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the tilt about the base's origin at each pose (N, 4, 4)."""
        d = self.details
        moments = world.weight_moments(q, np.zeros(3))
        tilts = d["factor"] * _tilt(moments, d["holds_n_m"], d["softer"], d["soft_side_rad"])
        return np.array([transform(rotation_from_vector(tilt), np.zeros(3)) for tilt in tilts])


def _tilt(moments: Array, hold: float, soft: float, side: float) -> Array:
    """Return tilts (N, 3) before scaling, for moments (N, 3) [N m], preload [N m], softness and direction [rad] of the soft side."""
    size = np.linalg.norm(moments, axis=1)
    beyond = np.maximum(size - hold, 0.0) / np.where(size > 0, size, 1.0)
    leaning = np.arctan2(moments[:, 1], moments[:, 0]) - side
    softness = 1.0 + (soft - 1.0) * np.maximum(np.cos(leaning), 0.0)
    return (softness * beyond)[:, None] * moments
