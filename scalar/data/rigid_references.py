"""Readings of reference nests that contradict the others: the distances between nests on one base are the same at all poses.

No motion of the tracker or the base changes these distances, so a reading that does not keep them is of something else, for example of another
reflector. A few such readings would decide the motion that is estimated from all of them.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from scalar.geometry.se3 import Array

_MOST_STD = 10.0  # a distance is wrong that is off by more than this many standard deviations, estimated by the shortest half
_LEAST = 5e-4  # m: and by more than this, which no noise of a tracker is
_AS_SHORT = 2.0  # times the shortest interval: others are about as short
_LEAST_POSES = 5  # poses at which both nests of a pair were seen, from which their distance is known
# Share of the readings. Where more of them contradict one another, the nests themselves do not stay where they are.
_MOST_SHARE = 0.2


def strange_readings(pose: Array, nest: Array, points: Array) -> dict[int, float]:
    """Return by how much readings contradict the others [m], by their rows.

    At each pose, the nest whose distances to others are wrong most often is taken to be the wrong one, until no wrong distance is left. Of two nests
    that are seen alone, both are.

    Args:
        pose: ``(Q,)``, the pose of each reading, within one session.
        nest: ``(Q,)`` int, its nest.
        points: ``(Q, 3)`` [m], measured positions.
    """
    rows = {(int(p), int(k)): i for i, (p, k) in enumerate(zip(pose, nest, strict=True))}
    of_pose: dict[int, dict[tuple[int, int], float]] = {}
    for first, second in combinations(sorted({int(k) for k in nest}), 2):
        shared = [int(p) for p in np.unique(pose) if (int(p), first) in rows and (int(p), second) in rows]
        if len(shared) < _LEAST_POSES:
            continue
        apart = [points[rows[p, first]] - points[rows[p, second]] for p in shared]
        distance = np.linalg.norm(apart, axis=1)
        centre, std = _of_shortest_half(distance)
        off = np.abs(distance - centre)
        limit = max(_MOST_STD * std, _LEAST)
        for k in np.flatnonzero(off > limit):
            of_pose.setdefault(shared[k], {})[first, second] = float(off[k])
    found: dict[int, float] = {}
    for p, wrong in of_pose.items():
        while wrong:
            nests = sorted({k for pair in wrong for k in pair})
            weights = {
                k: (sum(k in pair for pair in wrong), sum(d for pair, d in wrong.items() if k in pair))
                for k in nests
            }
            worst = max(weights.values())
            blamed = [k for k in nests if weights[k] == worst]
            for k in blamed:
                found[rows[p, k]] = max(d for pair, d in wrong.items() if k in pair)
            wrong = {pair: d for pair, d in wrong.items() if not set(pair) & set(blamed)}
    return found if len(found) <= _MOST_SHARE * len(pose) else {}


def _of_shortest_half(values: Array) -> tuple[float, float]:
    """Return the middle of the shortest interval that holds half of some numbers ``(k,)``, and their standard deviation by its length.

    Unlike a median, it stays with one of two values, as of a distance to a nest that was knocked in the middle of a campaign (Rousseeuw and Leroy,
    Robust Regression and Outlier Detection, 1987). Of intervals that are about as short, the one with the earlier numbers is taken.
    """
    order = np.argsort(values, kind="stable")
    half = max(len(order) // 2, 2)
    windows = np.lib.stride_tricks.sliding_window_view(order, half)
    widths = values[windows[:, -1]] - values[windows[:, 0]]
    short = np.flatnonzero(widths <= _AS_SHORT * widths.min())
    chosen = windows[short[np.argmin(windows[short].mean(axis=1))]]
    return float(values[chosen].mean()), float(widths.min()) / 1.349
