"""Moments at which an arm stands still, found in the recorded joint positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.ingest.bag import LEAST, SETTLED, STILL


@dataclass(frozen=True, eq=False)
class Still:
    """One moment at which the arm stands still.

    Attributes:
        start, end: [s], from when it has settled until it moves on.
        q: ``(n,)`` [rad, m], the mean position meanwhile.
    """

    start: float
    end: float
    q: Array


def still_moments(
    times: Array, positions: Array, still: float = STILL, settled: float = SETTLED, least: float = LEAST
) -> list[Still]:
    """Return the moments at which no joint moves, in order of time.

    Args:
        times: ``(J,)`` [s], ascending.
        positions: ``(J, n)`` [rad, m].
        still: By how much every joint's position may vary [rad, m].
        settled: From how long after the last motion the arm is taken to stand [s].
        least: How long it stands at least from then on [s].
    """
    found: list[Still] = []
    i = 0
    while i < len(times):
        j = _until(positions, i, still)
        if times[j - 1] - times[i] >= settled + least:
            inside = slice(int(np.searchsorted(times, times[i] + settled)), j)
            found.append(Still(float(times[inside][0]), float(times[j - 1]), positions[inside].mean(axis=0)))
            i = j
        else:
            i += 1
    return found


def _until(positions: Array, i: int, still: float) -> int:
    """Return the first sample after i at which some joint is farther than ``still`` from another position since i."""
    size = 64
    while True:
        part = positions[i : i + size]
        spread = np.maximum.accumulate(part, axis=0) - np.minimum.accumulate(part, axis=0)
        moved = np.flatnonzero((spread > still).any(axis=1))
        if len(moved):
            return i + int(moved[0])
        if i + size >= len(positions):
            return len(positions)
        size *= 2
