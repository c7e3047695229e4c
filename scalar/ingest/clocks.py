"""Whether the clocks of two tables agree: points that are joined to the next pose rather than to their own.

A program that measures at each pose does so with nearly the same delay, but moves take different times. If the clock of one table is wrong by about
the time between two poses, the delays to the nearest poses scatter widely, and there is another correction of the clock with which they hardly do.
Where all moves take equally long, no time shows such an error.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

_ENOUGH = 20  # points; of fewer, some correction may fit by chance
_SHARE = 0.8  # of the points that have to agree; the others may be reference points, or measured again
_CLEARLY_LESS = 0.25  # scatter with another correction, over that with the stated one
# [s] a clock that is wrong by more is that of another time zone, and none of its points is near a pose.
_LONGEST = 3600.0
_SMALL = 0.1  # scatter over the typical time between poses with which no point is nearest to another pose than its own
_STEPS = 16.0  # corrections that are tried for each typical time between poses
_MOST = 20_000  # corrections that are tried
_MOST_POINTS = 1_000  # points that are looked at: of more, as a scanner has, some spread over the file


def better_correction(time: Array, clock: Array, group: Array) -> tuple[float, float, float] | None:
    """Return the correction of a clock with which delays scatter much less, and the scatter without and with it; None if there is none.

    Args:
        time: ``(N,)`` times of points [s].
        clock: ``(M,)`` times of poses [s].
        group: ``(N,)``, which target a point is of; each may have its own delay.

    Returns:
        What has to be added to ``time``, so that the typical delay is zero; then, without and with it, the distance from the typical delay of
        their target within which most points lie. All in seconds.
    """
    if len(time) > _MOST_POINTS:
        some = np.linspace(0, len(time) - 1, _MOST_POINTS).round().astype(int)
        time, group = time[some], group[some]
    clock = np.unique(clock)
    if len(time) < _ENOUGH or len(clock) < 3:
        return None
    typical = float(np.median(np.diff(clock)))
    members = [np.flatnonzero(group == name) for name in np.unique(group)]
    now = _scatter(_delays(time, clock), members)
    if now < _SMALL * typical:
        return None
    shifts = np.arange(-_LONGEST, _LONGEST, max(typical / _STEPS, 2.0 * _LONGEST / _MOST))
    scatter = np.array([_scatter(_delays(time + shift, clock), members) for shift in shifts])
    equal = np.flatnonzero(scatter <= scatter.min() + 1e-6)
    best = float(shifts[equal[np.argmin(np.abs(shifts[equal]))]])
    if scatter.min() > _CLEARLY_LESS * now:
        return None
    return best - float(np.median(_delays(time + best, clock))), now, float(scatter.min())


def _delays(time: Array, clock: Array) -> Array:
    """Return ``(N,)``: how long after the nearest of the times ``(M,)``, which are sorted, each time is [s]."""
    above = np.clip(np.searchsorted(clock, time), 1, len(clock) - 1)
    below = above - 1
    nearer = np.where(time - clock[below] <= clock[above] - time, below, above)
    return time - clock[nearer]


def _scatter(delay: Array, members: list[Array]) -> float:
    """Return the distance from the median of its group within which most delays lie [s]."""
    away = np.empty(len(delay))
    for rows in members:
        away[rows] = np.abs(delay[rows] - np.median(delay[rows]))
    return float(np.quantile(away, _SHARE))
