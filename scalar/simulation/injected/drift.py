"""A base that settles on its floor during the run; the data are the same as if the measuring equipment moved."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array, rotation_from_vector, transform
from scalar.simulation.world import World

LEVER = 3.0  # m; the base turns by size / LEVER while it shifts by size
SETTLES = (0.2, 1.0)  # time constant of the settling, as a share of the run


@dataclass(frozen=True, eq=False)
class TargetDrift(InjectedEffect):
    """The base shifts by size and turns by size over `LEVER`, in drawn directions; the motion grows as 1 - exp(-share of the run / constant)."""

    name: ClassVar[str] = "target_drift"
    unit: ClassVar[str] = "m"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the time."""
        return {"time"}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the directions and the time constant."""
        shift, turn = rng.standard_normal((2, 3))
        details = {
            "direction": (shift / np.linalg.norm(shift)).tolist(),
            "axis": (turn / np.linalg.norm(turn)).tolist(),
            "turns_rad": float(entry["size"] / LEVER),
            "constant": float(rng.uniform(*SETTLES)),
            "end_s": float(stage.poses["time"].iloc[-1]),
        }
        return cls({}, entry["size"], details)

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the motion of the base (N, 4, 4) at each pose of the run; the identity if the poses have no time."""
        if "time" not in poses:
            return np.eye(4)
        d = self.details
        share = 1.0 - np.exp(-poses["time"].to_numpy(float) / d["end_s"] / d["constant"])
        turns = share[:, None] * d["turns_rad"] * np.array(d["axis"])
        shifts = share[:, None] * self.size * np.array(d["direction"])
        return np.array(
            [transform(rotation_from_vector(w), t) for w, t in zip(turns, shifts, strict=True)]
        ).reshape(-1, 4, 4)
