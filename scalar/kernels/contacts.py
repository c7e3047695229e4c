"""Compute contact vectors, tangents of planes, and the scatter of scans about their lines, by the compiled library; None without it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scalar import kernels
from scalar.kernels import Array, address, checked, contiguous


def contacts(
    T_base_sensor: Array, normals: Array, distances: Array, index: NDArray[np.int64]
) -> Array | None:
    """Return the contact vectors ``(N, 3)``, as ``contact_vectors`` of ``scalar.sensors.profile`` defines them.

    Args:
        T_base_sensor: ``(N, 4, 4)``.
        normals: ``(K, 3)``, unit normals of the planes.
        distances: ``(K,)`` [m].
        index: ``(N,)``, which plane each pose measures.
    """
    if kernels.LIBRARY is None:
        return None
    # The few normals are copied, because they are read-only, and the address of such an array takes ten times as long as a copy.
    T, normals, distances = contiguous(T_base_sensor), contiguous(normals.copy()), contiguous(distances)
    index = np.ascontiguousarray(index, dtype=np.int64)
    found = np.empty((len(T), 3))
    at = (address(array) for array in (T, normals, distances, index, found))
    kernels.LIBRARY.contacts(len(T), *at)
    return found


def tangents(normals: Array) -> Array | None:
    """Return two unit vectors ``(K, 2, 3)`` perpendicular to each unit normal ``(K, 3)`` and to each other."""
    if kernels.LIBRARY is None:
        return None
    normals = contiguous(normals)
    found = np.empty((len(normals), 2, 3))
    kernels.LIBRARY.tangents(len(normals), address(normals), address(found))
    return found


def scatter(R: Array, c: Array, full: Array | None) -> Array | None:
    """Return for each scan the squared residual that no line explains ``(N,)``; arguments as for ``scatter_within`` of ``scalar.sensors.profile``."""
    if kernels.LIBRARY is None:
        return None
    R, c, added = contiguous(R), contiguous(c), None if full is None else contiguous(full)
    found = np.empty(len(R))
    at = None if added is None else address(added)
    checked(kernels.LIBRARY.scatter(*R.shape, address(R), address(c), at, address(found)))
    return found


def off_lines(points: Array, starts: NDArray[np.int64]) -> Array | None:
    """Return the sum of the squared distances of each scan's points from its line of least squares ``(N,)`` [m^2].

    Args:
        points: ``(P, 2)`` [m], of all scans.
        starts: ``(N + 1,)``, index of the first point of each scan, and P.
    """
    if kernels.LIBRARY is None:
        return None
    points, starts = contiguous(points), np.ascontiguousarray(starts, dtype=np.int64)
    found = np.empty(len(starts) - 1)
    kernels.LIBRARY.off_lines(len(found), *(address(array) for array in (points, starts, found)))
    return found
