"""The order in which a program takes poses, so that moves between them are short: an open tour, nearest neighbour and then 2-opt.

The length of a move is the largest rotation of any joint; the time of the move is proportional to it if all joints are equally fast. A metre of
a prismatic joint counts as a radian.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

_STARTS = 8  # tours begun at different poses, of which the best is taken


def move_lengths(q: Array) -> Array:
    """Return the lengths ``(N, N)`` [rad] of the moves between poses ``(N, n)`` [rad]."""
    return np.max(np.abs(q[:, None] - q[None]), axis=2)


def program_order(lengths: Array) -> list[int]:
    """Return an order of N poses in which the sum of the moves is small, and not larger than in the given order.

    Args:
        lengths: ``(N, N)``, symmetric.
    """
    N = len(lengths)
    starts = np.unique(np.linspace(0, N - 1, min(_STARTS, N)).astype(int))
    tours = [
        _improved(lengths, tour) for tour in [list(range(N)), *(_nearest(lengths, int(s)) for s in starts)]
    ]
    return min(tours, key=lambda tour: tour_length(lengths, tour))


def tour_length(lengths: Array, tour: list[int]) -> float:
    """Return the sum of the lengths of the moves of a tour, in the unit of ``lengths``.

    Args:
        lengths: ``(N, N)``, length of the move from each pose to each other.
        tour: Indices of the poses, in their order.
    """
    return float(lengths[tour[:-1], tour[1:]].sum())


def _nearest(lengths: Array, start: int) -> list[int]:
    """Return the tour that begins at a pose and always goes on to the nearest pose that is left."""
    tour, left = [start], set(range(len(lengths))) - {start}
    while left:
        here = tour[-1]
        tour.append(min(left, key=lambda i: (lengths[here, i], i)))
        left.remove(tour[-1])
    return tour


def _improved(lengths: Array, tour: list[int]) -> list[int]:
    """Return the tour with stretches reversed as long as that makes it shorter (2-opt of an open tour)."""
    t = np.array(tour)
    N = len(t)
    if N < 3:
        return tour
    # Moves to and from a fictitious pose N have no length, so that stretches at the ends can be reversed as well.
    D = np.zeros((N + 1, N + 1))
    D[:N, :N] = lengths
    t = np.r_[N, t, N]
    improved = True
    while improved:
        improved = False
        for i in range(1, N):
            j = np.arange(i + 1, N + 1)
            change = D[t[i - 1], t[j]] + D[t[i], t[j + 1]] - D[t[i - 1], t[i]] - D[t[j], t[j + 1]]
            k = int(np.argmin(change))
            if change[k] < -1e-12:
                t[i : j[k] + 1] = t[i : j[k] + 1][::-1]
                improved = True
    return [int(i) for i in t[1:-1]]
