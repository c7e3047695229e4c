"""Whether the poses of a campaign follow one path, so that a change in time and an error that depends on the place are confounded."""

from __future__ import annotations

import numpy as np

from scalar.data.moves import STILL
from scalar.geometry.se3 import Array

# Chosen. At random poses the median ratio of the distances below is 0.5 to 0.9, and 1 to 2.8 on grids, in sockets of a plate, and on planes that are
# scanned one after the other; on one path of real and of simulated arms it is 3.4 to 5.4.
_TIMES_FARTHER = 3.0
_MOST_COMPARED = 200  # poses whose distances from the others are computed
_FEWEST = 20  # poses; with fewer, a path is not distinguished from other sequences
_LATER = 5  # poses are of other times if more than a fifth of all poses lies between them
_SOON = 20  # poses are of the same time if at most a twentieth of all poses lies between them


def follow_one_path(q: Array, still: float | Array = STILL) -> bool:
    """Return whether poses of other times stand much farther away than those of the same time: the arm never came back to where it had been.

    Distances are Euclidean, of joint positions in units of their standard deviations. Successive readings of one pose count as one.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides], in the order of acquisition.
        still: By how much a joint may move and count as standing still, one number or ``(n,)`` in the same units.
    """
    least = np.broadcast_to(still, q.shape[1])
    moved = np.ptp(q, axis=0) > least if len(q) else np.zeros(q.shape[1], dtype=bool)
    q, least = q[:, moved], least[moved]
    if not q.size:
        return False
    q = q[np.r_[True, np.any(np.abs(np.diff(q, axis=0)) > least, axis=1)]]
    count = len(q)
    if count < _FEWEST:
        return False
    q = q / q.std(axis=0)
    compared = np.unique(np.linspace(0, count - 1, _MOST_COMPARED).astype(int))
    farther = 0
    for i in compared:
        between = np.abs(np.arange(count) - i)
        distance = np.linalg.norm(q - q[i], axis=1)
        soon = distance[(between > 0) & (between <= max(2, count // _SOON))].min()
        farther += distance[between > count // _LATER].min() > _TIMES_FARTHER * soon
    return farther > len(compared) / 2
