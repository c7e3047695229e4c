"""What the way from the pose before leaves: angles that are logged on the way, and play on the side from which a joint came."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import JointError
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World


@dataclass(frozen=True, eq=False)
class LeftByMoves(JointError):
    """An error of one joint that the order of the poses makes.

    Attributes:
        left: (N,) [rad], what the way to each pose of the scene left; None for the evaluation poses, which are reached one by one and rest.
    """

    left: Array | None = None

    def at_rest(self) -> Self:
        """Return the effect without what the ways left."""
        return type(self)(self.target, self.size, self.details)

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return what the way to each pose left."""
        return np.zeros(len(q)) if self.left is None else self.left[poses["pose"].to_numpy()]


@dataclass(frozen=True, eq=False)
class PoseLag(LeftByMoves):
    """A joint comes to rest exponentially, and its angle is logged when a share of the way is still to go.

    With p where it rests: read = p - size (p - p_before), so p = (read - size p_before) / (1 - size), pose after pose.
    """

    name: ClassVar[str] = "pose_lag"
    unit: ClassVar[str] = "rad/rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint."""
        target = {"joint": stage.draw_joint(rng)} | entry["target"]
        read, share = stage.q[:, target["joint"] - 1], entry["size"]
        rests = read.copy()
        for k in range(1, len(read)):
            rests[k] = (read[k] - share * rests[k - 1]) / (1.0 - share)
        return cls(target, share, {}, rests - read)


@dataclass(frozen=True, eq=False)
class BacklashByMoves(LeftByMoves):
    """Play that nothing but the order of the poses tells: a joint that moved up rests on the one side, one that moved down on the other."""

    name: ClassVar[str] = "joint_backlash"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint; it came to the first pose from below."""
        target = {"joint": stage.draw_joint(rng)} | entry["target"]
        read = stage.q[:, target["joint"] - 1]
        side = np.ones(len(read))
        for k in range(1, len(read)):
            side[k] = side[k - 1] if read[k] == read[k - 1] else (1.0 if read[k] > read[k - 1] else -1.0)
        return cls(target, entry["size"], {"by": "moves"}, entry["size"] * side)
