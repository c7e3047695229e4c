"""Order poses so that the straight joint moves between them touch nothing, if a few rounds of ordering find such an order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from scalar.geometry.se3 import Array
from scalar.planning.candidates import Allowed
from scalar.planning.program_order import move_lengths, program_order

# Largest turn of any joint between two tests for collision [rad]: 10 cm at the end of an arm of 1 m.
_STEP = 0.1
_ROUNDS = 6
_DETOUR = 10.0  # rad; added to the length of a move that touches something, so that the order avoids it


def order_poses(q: Array, allowed: Allowed | None) -> tuple[list[int], list[int]]:
    """Return an order of N poses with short moves, and the positions in this order after which a straight joint move touches something.

    Args:
        q: ``(N, n)`` [rad], joint angles.
        allowed: Says which joint angles touch nothing; None if collisions are not tested, and then no move counts as touching.
    """
    lengths = move_lengths(q)
    tour = program_order(lengths)
    if allowed is None:
        return tour, []
    blocked: dict[tuple[int, int], bool] = {}
    best: tuple[list[int], list[int]] | None = None
    for _ in range(_ROUNDS):
        for i, j in pairwise(tour):
            key = (min(i, j), max(i, j))
            if key not in blocked:
                blocked[key] = not bool(np.all(allowed(_between(q[i], q[j]))))
        touching = [k for k, (i, j) in enumerate(pairwise(tour)) if blocked[min(i, j), max(i, j)]]
        if best is None or len(touching) < len(best[1]):
            best = tour, touching
        if not touching:
            break
        raised = lengths.copy()
        for (i, j), blocks in blocked.items():
            if blocks:
                raised[i, j] = raised[j, i] = lengths[i, j] + _DETOUR
        tour = program_order(raised)
    assert best is not None
    return best


def _between(start: Array, end: Array) -> Array:
    """Return joint angles ``(K, n)`` [rad] along a straight move, without its ends."""
    n = int(np.ceil(np.max(np.abs(end - start)) / _STEP))
    share = np.arange(1, max(n, 2))[:, None] / max(n, 2)
    return start + share * (end - start)
