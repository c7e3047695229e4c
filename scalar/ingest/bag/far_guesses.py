"""A plane whose guess is too far off for the scans on it: where these scans show it to be, by the nominal arm.

The scans of such a plane are lost, although nothing is wrong with the joints. A wrong zero of joint 1 may put them on another plane of the same
distance, so that the guess has to be compared with every other reading.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.geometry.se3 import Array
from scalar.ingest.bag.labels import FARTHEST, Labels, label_scans

_FARTHEST_GUESS = 1.0  # m; chosen: a guess that is farther off is none of this plane
_FEWEST = 3  # scans that show a plane
_MOST_KEPT = (
    0.1  # share of the lost scans that a plane may have as it was guessed: else its guess is near enough
)


def with_far_guesses(scans: Sequence[Array], normals: Array, distances: Array) -> tuple[Array, Labels]:
    """Return other distances of planes ``(K,)`` [m], with which lost scans lie on them, and the planes of all scans then.

    A distance is changed only of a plane on which hardly any scan lies, and only if the lost scans, as they are, lie on one plane parallel to it.

    Args:
        scans: S arrays ``(M, 3)`` [m], in the base frame.
        normals, distances: ``(K, 3)`` and ``(K,)`` [m], guesses: ``normal . p = distance``.
    """
    distances = distances.copy()
    labels = label_scans(scans, normals, distances)
    for _ in range(len(normals)):
        best: tuple[Array, Labels] | None = None
        lost = np.flatnonzero(labels.index < 0)
        for k in range(len(normals)):
            if len(lost) < _FEWEST or np.count_nonzero(labels.index == k) > _MOST_KEPT * len(lost):
                continue
            moved = distances.copy()
            moved[k] = _densest(
                [float(np.mean(scans[i] @ normals[k])) for i in lost.tolist()], float(distances[k])
            )
            found = label_scans(scans, normals, moved)
            if _count(found) > _count(best[1] if best else labels):
                best = moved, found
        if best is None:
            break
        distances, labels = best
    return distances, labels


def _count(labels: Labels) -> int:
    """Return how many scans lie on a plane."""
    return int(np.count_nonzero(labels.index >= 0))


def _densest(offsets: Sequence[float], guess: float) -> float:
    """Return the median [m] of the largest group of distances along a normal that lie near one another, none too far from a guess; else the guess."""
    near = np.array([offset for offset in offsets if abs(offset - guess) <= _FARTHEST_GUESS])
    if not len(near):
        return guess
    together = np.abs(near[:, None] - near) <= FARTHEST / 2
    return float(np.median(near[together[int(np.argmax(together.sum(axis=1)))]]))
