"""The base classes of the causes: entries `unknown` with a kind, some with states that depend on the moves from pose to pose."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World


@dataclass(frozen=True, eq=False)
class Cause(InjectedEffect):
    """One physical cause.

    Attributes:
        states: (N, ...), one row for each pose of the scene: quantities that depend on the order, the time or the moves of the poses, as each
            cause states. None for the evaluation poses, each of which is reached at rest, and for causes without such quantities.
    """

    states: Array | None = None

    name: ClassVar[str] = "unknown"
    unit: ClassVar[str] = "rad"
    kind: ClassVar[str]
    of_a_joint: ClassVar[bool] = False

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return `{"time"}`, since moves and climates depend on it."""
        return {"time"}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw what the entry leaves open."""
        if "joint" in entry["target"] and not cls.of_a_joint:
            stage.refuse("target.joint", f"'{cls.kind}' has no joint")
        return cls.drawn(dict(entry["target"]), entry["size"], stage, rng)

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Return the cause in a workcell, with what `target` leaves open drawn; each cause defines this."""
        raise NotImplementedError

    @classmethod
    def details_of(cls, depends_on: list[str], **others: Any) -> dict[str, Any]:
        """Return details for the truth: the kind, the columns on which the error depends, and further numbers."""
        return {"kind": cls.kind, "unit": cls.unit, "depends_on": depends_on, **others}

    def at_rest(self) -> Self:
        """Return the cause without states."""
        return replace(self, states=None)

    def state(self, poses: pd.DataFrame) -> Array | None:
        """Return the states of these poses of the scene, None at rest."""
        return None if self.states is None else self.states[poses["pose"].to_numpy()]


@dataclass(frozen=True, eq=False)
class MoveCause(Cause):
    """Errors of the joints that depend on the moves: `states` (N, n) [rad]; there are none at rest."""

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]."""
        state = self.state(poses)
        return np.zeros_like(q) if state is None else state


def scaled(errors: Array, size: float) -> tuple[Array, float]:
    """Return errors (any shape) multiplied by a factor so that their largest magnitude is `size`, and the factor.

    `size` has the unit of the errors. The factor is 0 if all errors are 0.
    """
    largest = float(np.abs(errors).max())
    factor = size / largest if largest > 0 else 0.0
    return errors * factor, factor


def every_joint(n: int) -> list[str]:
    """Return the names q1..qn."""
    return [f"q{j + 1}" for j in range(n)]
