"""An arm whose motors warm its links while it works, and which cools while it stands still: two bodies that exchange heat."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
import pandas as pd

from scalar.simulation.config import length_names
from scalar.simulation.injected.links import ThermalDrift
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

STANDS_S = 60.0  # a longer interval between two poses is one in which the arm stood still
CONSTANT = (0.15, 0.6)  # drawn: the links' time constant over the time that is worked
MOTORS = 0.2  # heat capacity of the motors over that of the links
TO_LINKS = 4.0  # heat that passes from motors to links, over what links lose to the room, each for a difference of one kelvin
STEPS = 200  # steps of the integration in one time constant


@dataclass(frozen=True, eq=False)
class RestartedWarmUp(ThermalDrift):
    """Lengths grow by size times the warmth of the links, which is 1 in an arm that works for ever and 0 in a cold one.

    With m and w the warmth of motors and links: MOTORS tau dm/dt = p - TO_LINKS (m - w), tau dw/dt = TO_LINKS (m - w) - w; p is 1 at work and 0
    at rest.

    Attributes:
        clock: (K,) [s], at which the warmth is known.
        warmth: (K,), of the links.
    """

    clock: Array = field(default_factory=lambda: np.zeros(1))
    warmth: Array = field(default_factory=lambda: np.zeros(1))

    name = "restarted_warm_up"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the time."""
        return {"time"}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the time constant, if the entry states none."""
        time = stage.poses["time"].to_numpy(float)
        intervals = np.diff(time)
        works = intervals <= STANDS_S
        share = float(rng.uniform(*CONSTANT))
        constant = entry["constant_s"] or share * float(intervals[works].sum())
        clock, warmth = warmed(time, works, constant)
        details = {
            "constant_s": constant,
            "stops": int((~works).sum()),
            "lengths": entry["lengths"] or length_names(stage.arm.n),
        }
        return cls({}, entry["size"], details, clock, warmth)

    def growth(self, poses: pd.DataFrame) -> Array:
        """Return the relative growth of the lengths at each pose (N,) [m/m]."""
        return self.size * np.interp(poses["time"].to_numpy(float), self.clock, self.warmth)


def warmed(time: Array, works: Array, constant: float) -> tuple[Array, Array]:
    """Return the warmth (N,) of the links at the times (N,) [s] of the poses, and these times, by the midpoint rule.

    Args:
        time: of the poses, ascending [s].
        works: (N - 1,) bool, whether the arm works between a pose and the next.
        constant: of the links alone [s].
    """

    def rates(state: Array, power: float) -> Array:
        passed = TO_LINKS * (state[0] - state[1])
        return np.array([(power - passed) / MOTORS, passed - state[1]]) / constant

    state, found = np.zeros(2), [0.0]
    for start, end, at_work in zip(time[:-1], time[1:], works, strict=True):
        count = max(int(np.ceil(STEPS * (end - start) / constant)), 1)
        step, power = (end - start) / count, float(at_work)
        for _ in range(count):
            half = state + step / 2 * rates(state, power)
            state = state + step * rates(half, power)
        found.append(float(state[1]))
    return time, np.array(found)
