"""Errors that depend on the earlier poses: angles logged before a joint is at rest, play taken up by the last move, and friction with hysteresis."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import JointError
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

SPRINGS = 20  # number of springs in the model of friction


@dataclass(frozen=True, eq=False)
class MoveError(JointError):
    """An error of one joint that depends on the order of the poses.

    Attributes:
        errors: (N,) [rad], the joint's error at each pose of the scene; None for the evaluation poses, each of which is reached at rest.
    """

    errors: Array | None = None

    def at_rest(self) -> Self:
        """Return the effect without errors."""
        return type(self)(self.target, self.size, self.details)

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the joint's error at each pose."""
        return np.zeros(len(q)) if self.errors is None else self.errors[poses["pose"].to_numpy()]


@dataclass(frozen=True, eq=False)
class PoseLag(MoveError):
    """A joint comes to rest exponentially, and its angle is logged when a share `size` of the move is still to go.

    With p the angle at rest: read = p - size (p - p_before), so p = (read - size p_before) / (1 - size), pose after pose.
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
class BacklashByMoves(MoveError):
    """Play whose side only the order of the poses shows: a joint that moved up rests on one side, one that moved down on the other."""

    name: ClassVar[str] = "joint_backlash"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint, which reached the first pose from below."""
        target = {"joint": stage.draw_joint(rng)} | entry["target"]
        read = stage.q[:, target["joint"] - 1]
        side = np.ones(len(read))
        for k in range(1, len(read)):
            side[k] = side[k - 1] if read[k] == read[k - 1] else (1.0 if read[k] > read[k - 1] else -1.0)
        return cls(target, entry["size"], {"by": "moves"}, entry["size"] * side)


@dataclass(frozen=True, eq=False)
class JointHysteresis(MoveError):
    """Friction winds a joint up: springs in parallel, each with a slider that slips at its own travel (Maxwell-slip model).

    Each spring is stretched by the motion of the joint, at most to the travel of its slider. The error is `size` times the mean over the springs
    of stretch over travel; this mean is 1 after a long move upwards, and -1 after one downwards.
    """

    name: ClassVar[str] = "joint_hysteresis"
    unit: ClassVar[str] = "rad"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the time, which tells the order of the poses."""
        return {"time"}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint, whose springs are relaxed at the first pose."""
        target = {"joint": stage.draw_joint(rng)} | entry["target"]
        read = stage.q[:, target["joint"] - 1]
        error = entry["size"] * stretched(read, entry["travel_rad"])
        return cls(target, entry["size"], {"travel_rad": entry["travel_rad"]}, error)


def stretched(angle: Array, travel: float) -> Array:
    """Return the mean over the springs of stretch over travel (N,), between -1 and 1, at each pose of a joint.

    Args:
        angle: the joint's angle at the poses in their order (N,) [rad]; between poses the joint moves directly.
        travel: mean travel at which the sliders slip [rad]; the travels are evenly spaced between zero and twice that.
    """
    slips = 2.0 * travel * (np.arange(SPRINGS) + 0.5) / SPRINGS
    stretch, found = np.zeros(SPRINGS), [0.0]
    for move in np.diff(angle):
        stretch = np.clip(stretch + move, -slips, slips)
        found.append(float(np.mean(stretch / slips)))
    return np.array(found)
