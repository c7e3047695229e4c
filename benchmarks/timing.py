"""Times that can be compared on a busy machine: processor time, contestants interleaved, medians, ratios."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.units import MS


@dataclass(frozen=True, eq=False)
class Times:
    """Processor times [s] of one contestant, one for each round."""

    seconds: np.ndarray

    @property
    def median(self) -> float:
        """Return the median [s]."""
        return float(np.median(self.seconds))

    @property
    def least(self) -> float:
        """Return the least [s], which other work on the machine disturbs least."""
        return float(np.min(self.seconds))


def line(name: str, times: Times) -> str:
    """Return a name with its median and least time [ms]."""
    return f"{name:48s}{times.median / MS:9.1f}{times.least / MS:9.1f}"


def interleaved(
    contestants: dict[str, Callable[[], Any]], rounds: int, clock: Callable[[], float] = time.process_time
) -> dict[str, Times]:
    """Return the times of contestants that take turns, so that whatever slows the machine slows all of them.

    Args:
        contestants: By name; each is called once before the clock runs.
        rounds: How often each is timed.
        clock: What a time is read from [s].
    """

    def timed(call: Callable[[], Any]) -> float:
        start = clock()
        call()
        return clock() - start

    return in_turns({name: lambda call=call: timed(call) for name, call in contestants.items()}, rounds)


def in_turns(contestants: dict[str, Callable[[], float]], rounds: int) -> dict[str, Times]:
    """Return the times of contestants that take turns and say themselves what they took [s], as programs of their own do.

    Args:
        contestants: By name; each is called once more before the first round.
        rounds: How often each is timed.
    """
    for call in contestants.values():
        call()
    seconds = {name: np.empty(rounds) for name in contestants}
    for i in range(rounds):
        for name, call in contestants.items():
            seconds[name][i] = call()
    return {name: Times(each) for name, each in seconds.items()}


def ratio(slow: Times, fast: Times) -> float:
    """Return how many times faster the second is: the median over rounds of the ratio within a round."""
    return float(np.median(slow.seconds / fast.seconds))


def middle_half(slow: Times, fast: Times) -> tuple[float, float]:
    """Return the quartiles of how many times faster the second is: half of the rounds have a ratio between them."""
    low, high = np.quantile(slow.seconds / fast.seconds, [0.25, 0.75])
    return float(low), float(high)
