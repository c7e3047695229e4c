"""When an arm worked and when it stood still, as the record of a campaign shows it."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from scalar.effects.acquisition import order_and_time
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# A pause counts as a stop if it lasts longer than so many usual intervals between poses, and than this share of the time at work; in a shorter
# pause an arm hardly cools. Both numbers are chosen.
STOP_INTERVALS = 10.0
STOP_SHARE = 0.05
USUAL = 0.9  # share of the intervals, the shortest, whose mean is the usual interval: stops are few
LEAST_POSES = 5  # poses of a stretch of work that counts; two such stretches are needed


def stretches_of_work(dataset: Dataset) -> tuple[str, list[tuple[float, float]]]:
    """Return the clock, ``time`` or ``order``, and from when to when the arm worked without a stop, by that clock; none where nothing shows stops.

    Stretches of fewer than ``LEAST_POSES`` poses are stretches of work too, but two longer ones are needed.
    """
    order, time = order_and_time(dataset)
    sessions = dataset.session
    if time is not None and not _overlap(time, sessions):
        clock, by = np.sort(time), "time"
        new = _stops(np.diff(clock))
    elif sessions is not None and not _overlap(order, sessions):
        rows = np.argsort(order, kind="stable")
        clock, by = order[rows], "order"
        new = np.diff(sessions[rows]) != 0
    else:
        return "order", []
    first = np.flatnonzero(np.r_[True, new])
    last = np.r_[first[1:], len(clock)] - 1
    if np.sum(last - first + 1 >= LEAST_POSES) < 2:
        return by, []
    return by, [(float(a), float(b)) for a, b in zip(clock[first], clock[last], strict=True)]


def _overlap(clock: Array, sessions: Array | None) -> bool:
    """Return whether two sessions overlap on a clock, as where it starts again with each."""
    if sessions is None:
        return False
    bounds = sorted((clock[sessions == s].min(), clock[sessions == s].max()) for s in np.unique(sessions))
    return any(after[0] <= before[1] for before, after in pairwise(bounds))


def _stops(intervals: Array) -> Array:
    """Return which intervals ``(N - 1,)`` between poses are stops, bool."""
    if not len(intervals):
        return np.zeros(0, dtype=bool)
    usual = float(np.mean(np.sort(intervals)[: max(int(USUAL * len(intervals)), 1)]))
    return (usual > 0.0) & (intervals >= usual * max(STOP_INTERVALS, STOP_SHARE * len(intervals)))
