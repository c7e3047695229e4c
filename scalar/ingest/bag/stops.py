"""Find the stops of an arm in recorded joint positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.ingest.bag import LEAST_TIME, SETTLED, STILL


@dataclass(frozen=True, eq=False)
class Stop:
    """One stop of the arm.

    Attributes:
        start, end: Times [s] of the first sample after the arm has settled, and of the last one before it moves on.
        q: ``(n,)`` [rad, m], the mean position between them.
    """

    start: float
    end: float
    q: Array


def find_stops(
    times: Array,
    positions: Array,
    still: float = STILL,
    settled: float = SETTLED,
    least_time: float = LEAST_TIME,
) -> list[Stop]:
    """Return the stops, during which no joint moves, in order of time; a position that is not finite is no stop, and ends one.

    Args:
        times: ``(J,)`` [s], ascending.
        positions: ``(J, n)`` [rad, m].
        still: Most by which the position of a joint that stands still may vary [rad, m].
        settled: Time from the last motion until the arm counts as settled [s].
        least_time: Least time for which it then stands still [s].
    """
    found: list[Stop] = []
    i = 0
    while i < len(times):
        j = _until(positions, i, still)
        if times[j - 1] - times[i] >= settled + least_time:
            inside = slice(int(np.searchsorted(times, times[i] + settled)), j)
            found.append(Stop(float(times[inside][0]), float(times[j - 1]), positions[inside].mean(axis=0)))
            i = j
        elif j == len(times):  # what begins later is shorter still
            break
        else:
            i += 1
    return found


def _until(positions: Array, i: int, still: float) -> int:
    """Return the first sample after i by which some joint has moved by more than ``still`` since i or is not finite, or the number of samples."""
    if not np.isfinite(positions[i]).all():
        return i + 1
    size = 64
    while True:
        part = positions[i : i + size]
        # A damaged recording may hold a signalling NaN, which counts as a move like any other.
        with np.errstate(invalid="ignore"):
            span = np.maximum.accumulate(part, axis=0) - np.minimum.accumulate(part, axis=0)
        moved = np.flatnonzero(~(span <= still).all(axis=1))
        if len(moved):
            return i + int(moved[0])
        if i + size >= len(positions):
            return len(positions)
        size *= 2
