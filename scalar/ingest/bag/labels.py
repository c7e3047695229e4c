"""Which target plane each scan lies on, by the nominal arm and the guesses of the planes, which are then corrected by the scans themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

FARTHEST = 0.15  # m from a guess that a scan may be: guesses are rough by a decimetre
CLEARLY = 2.0  # times nearer than to any other plane
ROUNDS = 3
_ENOUGH = 3  # scans from which a plane is fitted anew


@dataclass(frozen=True, eq=False)
class Labels:
    """The planes of S scans.

    Attributes:
        index: ``(S,)``, which plane; -1 where it is not clear, or none is near.
        distance: ``(S,)`` [m], root mean square distance of the scan from its plane as corrected.
    """

    index: Array
    distance: Array


def label_scans(scans: Sequence[Array], normals: Array, distances: Array) -> Labels:
    """Return which plane each scan lies on.

    Args:
        scans: S arrays ``(M, 3)`` [m], in the base frame.
        normals, distances: ``(K, 3)`` and ``(K,)`` [m], guesses: ``normal . p = distance``.
    """
    normals, distances = normals.copy(), distances.copy()
    index = np.full(len(scans), -1)
    away = np.zeros((len(scans), len(normals)))
    for _ in range(ROUNDS):
        for i, points in enumerate(scans):
            away[i] = np.sqrt(np.mean((points @ normals.T - distances) ** 2, axis=0))
        order = np.sort(away, axis=1)
        clear = (order[:, 0] < FARTHEST) & (order[:, 1] > CLEARLY * order[:, 0])
        new = np.where(clear, np.argmin(away, axis=1), -1)
        if np.array_equal(new, index):
            break
        index = new
        for k in range(len(normals)):
            mine = [scan for scan, plane in zip(scans, index, strict=True) if plane == k]
            if len(mine) >= _ENOUGH:
                normals[k], distances[k] = _plane(np.concatenate(mine), normals[k], distances[k])
    return Labels(index, away[np.arange(len(scans)), np.maximum(index, 0)])


def _plane(points: Array, normal: Array, distance: float) -> tuple[Array, float]:
    """Return the plane through points by least squares; as it was where they lie on a line."""
    centre = points.mean(axis=0)
    sizes, axes = np.linalg.svd(points - centre, full_matrices=False)[1:]
    if sizes[1] < 0.05 * sizes[0] or abs(float(axes[2] @ normal)) < np.cos(np.pi / 4):
        return normal, distance
    found = axes[2] * np.sign(axes[2] @ normal)
    return found, float(found @ centre)
