"""The base classes of all injected effects, which have a name, a target, a size and details for the truth."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.effects import Effects
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World


@dataclass(frozen=True, eq=False)
class InjectedEffect(Effects):
    """One effect in one workcell.

    Attributes:
        target: as in diagnosis.json.
        size: its meaning is that of the schema for this effect, in `unit`.
        details: whatever else was drawn or follows from the workcell, with units in the names.
    """

    target: dict[str, Any]
    size: float
    details: dict[str, Any]

    name: ClassVar[str]
    unit: ClassVar[str]

    @classmethod
    @abstractmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Return the effect that a complete entry of the config describes; what the entry leaves open is drawn."""

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return what poses.csv has to record for this effect, of "time", "temperature", "approach", "payload", "torque"."""
        return set()

    def record(self) -> list[dict[str, Any]]:
        """Return the entry in truth.json."""
        entry = {"name": self.name, "target": self.target, "size": self.size, "unit": self.unit}
        return [entry | self.details]


@dataclass(frozen=True, eq=False)
class JointError(InjectedEffect):
    """An effect on the angle of one joint, `target["joint"]`."""

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad], zero but for one joint."""
        dq = np.zeros_like(q)
        dq[:, self.target["joint"] - 1] = self.error(world, q, poses)
        return dq

    @abstractmethod
    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the joint's error (N,) [rad]."""
