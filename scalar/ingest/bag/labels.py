"""Which target plane each scan lies on, by the nominal arm and the guesses of the planes; the guesses are corrected by the scans on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

FARTHEST = 0.15  # m, largest distance of a scan from its plane: guesses are wrong by up to a decimetre
CLEARLY = 2.0  # a scan's plane is clear if every other plane is more than this many times farther away
ROUNDS = 3
_ENOUGH = 3  # least number of scans to which a plane is fitted


@dataclass(frozen=True, eq=False)
class Labels:
    """The planes of S scans.

    Attributes:
        index: ``(S,)``, the index of the plane; -1 where none is near, or two are.
        distance: ``(S,)`` [m], root mean square distance of the scan from that plane, as corrected; from the first plane where the index is -1.
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
    """Return normal and distance [m] of the least-squares plane through points ``(M, 3)`` [m].

    The given plane is returned instead if the points nearly lie on a line, or if the two planes differ by more than 45 degrees.
    """
    centre = points.mean(axis=0)
    sizes, axes = np.linalg.svd(points - centre, full_matrices=False)[1:]
    if sizes[1] < 0.05 * sizes[0] or abs(float(axes[2] @ normal)) < np.cos(np.pi / 4):
        return normal, distance
    found = axes[2] * np.sign(axes[2] @ normal)
    return found, float(found @ centre)
