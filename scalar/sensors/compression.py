"""Exact compression of scans: the residuals of M points become a few rows with the same sum of squares, by batched Gram-Schmidt.

The residual of a point is linear in a few functions of the point, ``f_i = b_i . c`` with ``b_i = [1, x_i, z_i]`` for a flat
plane. With ``B = Q R``, ``|B c|^2 = |R c|^2`` for every c, so the M residuals may be replaced by the rows of ``R c``. R is
built by Gram-Schmidt over the points, column by column, for all scans at once; it holds count, means, slope and scatter. The Cholesky factor
of the moment matrix would be the same R, but would lose half the digits, and would fail where the scatter is zero.
"""

from __future__ import annotations

import numpy as np

from scalar import kernels
from scalar.geometry.se3 import Array

_RANK_TOLERANCE = 1e-13  # times a column's own norm: a smaller remainder after projection is rounding


def compress(basis: Array, starts: Array) -> Array:
    """Return the triangular factor R of every scan, ``B_s = Q_s R_s``.

    Two sweeps of modified Gram-Schmidt ("twice is enough": Giraud et al., 2005) make R as accurate as Householder's method does. A column
    that depends linearly on those before it, as in a noise-free or very short scan, leaves a zero on the diagonal.

    Args:
        basis: ``(P, k)``, one row for each point, the points of a scan together.
        starts: ``(S + 1,)``, scan s owns ``basis[starts[s]:starts[s + 1]]``; no scan is empty.

    Returns:
        ``(S, k, k)``, upper triangular with a non-negative diagonal.
    """
    compiled = kernels.factors(basis, starts)
    return compress_keeping_q(basis, starts)[0] if compiled is None else compiled


def compress_keeping_q(basis: Array, starts: Array) -> tuple[Array, Array]:
    """Return ``(R, Q)`` with R as in ``compress`` and the orthonormal columns Q ``(P, k)`` of every scan."""
    first, counts = starts[:-1], np.diff(starts)
    k = basis.shape[1]
    Q = np.array(basis.T, dtype=float, order="C")
    R = np.zeros((len(first), k, k))
    for j in range(k):
        column = Q[j]
        size = np.sqrt(np.add.reduceat(column * column, first))
        for _sweep in range(2):
            for i in range(j):
                projection = np.add.reduceat(Q[i] * column, first)
                R[:, i, j] += projection
                column -= np.repeat(projection, counts) * Q[i]
        norm = np.sqrt(np.add.reduceat(column * column, first))
        live = norm > _RANK_TOLERANCE * size
        R[:, j, j] = np.where(live, norm, 0.0)
        column *= np.repeat(np.where(live, 1.0 / np.where(live, norm, 1.0), 0.0), counts)
    return R, Q.T


def line_basis(points: Array) -> Array:
    """Return ``[1, x, z]`` of every point, ``(P, 3)``: all that a flat plane's residual depends on."""
    return np.column_stack([np.ones(len(points)), points])
