"""Guess a scanner's pose from scans of planes by the compiled library, in turn with the planes."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from scalar import kernels
from scalar.kernels import Array, StartStruct, address, checked, contiguous


def linear_start(
    R: Array,
    R_metric: Array,
    T_base_flange: Array,
    index: NDArray[np.int64],
    use: NDArray[np.bool_],
    normals: Array,
    distances: Array,
    rounds: int,
) -> tuple[Array, Array] | None:
    """Return two guesses of the scanner's pose on the flange ``(4, 4)`` each: with the planes as given, and after rounds of fitting them anew.

    None is returned without the library, and where the scans do not clearly determine a guess.

    Args:
        R: ``(N, m, 3)``, whitened factors of ``[1, x, z]`` over the points of each scan.
        R_metric: ``(N, 3, 3)``, the triangular factors with equal weights of all points, in metres.
        T_base_flange: ``(N, 4, 4)``.
        index: ``(N,)``, which plane each scan is of.
        use: ``(N,)``, the scans of the first guess; later ones use all.
        normals: ``(K, 3)``, unit normals of the planes as first guessed.
        distances: ``(K,)`` [m].
        rounds: How often planes are fitted to the latest guess, and the pose is guessed with these planes.
    """
    if kernels.LIBRARY is None:
        return None
    R, *floats = (contiguous(each) for each in (R, R_metric, T_base_flange, normals, distances))
    index, used = (np.ascontiguousarray(each, dtype=np.int64) for each in (index, use))
    metric, T, n, d = (address(each) for each in floats)
    scans = StartStruct(
        len(R), len(normals), R.shape[1], address(R), metric, T, address(index), address(used), n, d
    )
    found = np.zeros((2, 4, 4))
    found[:, 3, 3] = 1.0
    first, last = found
    status = kernels.LIBRARY.linear_start(ctypes.byref(scans), rounds, address(first), address(last))
    checked(status)
    return (first, last) if status else None
