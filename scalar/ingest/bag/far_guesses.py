"""Planes whose guesses are so far off that their scans lie on no plane: find them where these scans are, by the nominal arm.

With such a guess the scans of the plane are not used, although nothing is wrong with the joints. A wrong zero of joint 1 may also put them on another
plane at the same distance, so that another guess has to be compared with every other reading.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from scalar.geometry.se3 import Array
from scalar.ingest.bag.straight_scans import Pieces
from scalar.units import MM

MISTAKE_STD = 250 * MM
"""Prior standard deviation of a mistake in the distance of a plane, whose number was measured to the wrong surface for example. Chosen."""
_FARTHEST_GUESS = 1.0  # m; chosen: scans that are farther from the guess are not on this plane
_FEWEST = 3  # chosen: least number of scans that show where a plane is
# Distance from every other plane from which on a scan may lie on the plane that is looked for.
_LOST = 30 * MM
# Scans of one plane, with the tilt of its guess, have distances along its normal that differ by less.
_TOGETHER = 75 * MM
_BETTER_BY = 5.0  # chosen: least fall of the cost [nats] with which another distance is taken


def with_far_guesses(pieces: Pieces) -> Iterator[tuple[Array, float]]:
    """Yield other distances of planes ``(K,)`` [m], one plane more at a time, each with what is added to the cost for its improbability.

    A distance is changed only if scans that lie on no other plane then lie on this one.
    """
    distances, least = pieces.distances, pieces.placement.cost
    for _ in pieces.plane_names:
        found: list[tuple[float, Array, float]] = []
        for k in np.flatnonzero(distances == pieces.distances).tolist():
            moved = distances.copy()
            moved[k] = _shown(pieces.read_otherwise(distances=distances), k)
            if moved[k] == distances[k]:
                continue
            added = 0.5 * float(np.sum(((moved - pieces.distances) / MISTAKE_STD) ** 2))
            found.append((pieces.read_otherwise(distances=moved).placement.cost + added, moved, added))
        best = min(found, key=lambda entry: entry[0], default=None)
        if best is None or best[0] > least - _BETTER_BY:
            return
        least, distances, added = best
        yield distances, added


def _shown(pieces: Pieces, k: int) -> float:
    """Return the distance [m] at which scans that lie on no other plane show plane k; the guess if too few do."""
    used = np.arange(len(pieces.plane_names)) != k
    placement = pieces.placed(used)
    frames = pieces.frames @ placement.T_flange_sensor
    others = pieces.nearest_of(placement, used)
    offsets = [
        float(
            np.mean(
                (points[:, :1] * pose[:3, 0] + points[:, 1:] * pose[:3, 2] + pose[:3, 3]) @ pieces.normals[k]
            )
        )
        for points, pose, nearest in zip(pieces.points, frames, others, strict=True)
        if nearest > _LOST
    ]
    return _densest(offsets, float(pieces.distances[k]))


def _densest(offsets: Sequence[float], guess: float) -> float:
    """Return the median [m] of the largest group of distances along a normal that lie near one another; the guess if there is none.

    Args:
        offsets: Distances [m] of the scans along the normal.
        guess: The stated distance [m]; distances farther from it than ``_FARTHEST_GUESS`` are left out.
    """
    near = np.array([offset for offset in offsets if abs(offset - guess) <= _FARTHEST_GUESS])
    if len(near) < _FEWEST:
        return guess
    together = np.abs(near[:, None] - near) <= _TOGETHER
    return float(np.median(near[together[int(np.argmax(together.sum(axis=1)))]]))
