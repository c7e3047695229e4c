"""Sparse regression beside noise that is common to a pose: which groups of columns explain the rows, all being in one model.

Every group of columns has a variance of its own, beside those of the poses' noises and of the rows:

    r = Q b + sum_k X_k c_k + sum_j D_j u_j + e,    c_k ~ N(0, g_k I),  u_j ~ N(0, v_j I),  e ~ N(0, s I)

The variances are those of greatest restricted likelihood. With C the covariance of r and P its inverse given Q,

    |X_k' P r|^2 = tr(X_k' P X_k)    for every g_k > 0, and likewise for v_j and s

at the optimum, whose fixed point is iterated (MacKay, Neural Computation 4, 1992). Most g_k become zero (sparse Bayesian learning: Tipping,
Journal of Machine Learning Research 1, 2001). In contrast to a choice of one group after the other, this finds groups that are significant only
once others are in the model, and a noise of the poses does not absorb what several groups explain together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from scalar.geometry.se3 import Array

_STEPS = 40  # further steps only sharpen variances, and the groups are tested again
_ROUNDING = 1e-10  # least variance of the rows over their mean square, and of a coefficient over its variance before: below, digits run out
_NOTHING = 1e-6  # of the variance of the rows: a group that adds less to a row on average is left out


@dataclass(frozen=True, eq=False)
class SparseRegression:
    """Where the iteration ends.

    Attributes:
        variance: Of the rows.
        pose_variances: ``(J,)``, of the noises common to a pose.
        kept: Indices of the groups that are left.
        significance: ``c' S^-1 c`` for each of these, S being the posterior covariance of its coefficients c.
        widths: How many directions each of these has.
    """

    variance: float
    pose_variances: Array
    kept: Array
    significance: Array
    widths: Array


def sparse_regression(
    rows: Array,
    Q: Array,
    groups: Sequence[Array],
    common: Sequence[Array],
    least_variance: float,
    unobservable_share: float = 1e-5,
) -> SparseRegression:
    """Return the groups that explain rows.

    Args:
        rows: ``(N, m)``, without components along Q.
        Q: ``(N m, F)``, what the model explains, orthonormal together with its rows on priors.
        groups: ``(N m, w_k)`` each, columns for a coefficient of the largest plausible size.
        common: ``(N, m, d_j)`` each, directions in which all rows of a pose err together.
        least_variance: Of the rows.
        unobservable_share: Of a group's squared length: directions of which less is left given Q are left out.
    """
    m = rows.shape[1]
    r = rows.ravel()
    X, owner, largest = _orthonormal(Q, groups, np.sqrt(unobservable_share))
    scale = np.array([1.0 / max(float(np.mean(np.sum(D * D, axis=(1, 2)))) / m, 1e-300) for D in common])
    kernels: list[Array] = [
        np.asarray(linalg.block_diag(*(a * D @ np.swapaxes(D, 1, 2))))
        for a, D in zip(scale, common, strict=True)
    ]
    power = float(r @ r) / len(r)
    least = max(least_variance, _ROUNDING * power)
    s, v = max(0.5 * power, least), np.full(len(kernels), 0.25 * power)
    g = np.minimum(power * len(r) / max(len(groups), 1), largest)
    for _ in range(_STEPS):
        P = _inverse(s, v, kernels, X * np.sqrt(g[owner]), Q)
        Pr, PX = P @ r, P @ X
        squares, traces = (
            np.bincount(owner, values, len(groups)) for values in ((X.T @ Pr) ** 2, np.sum(X * PX, axis=0))
        )
        g = np.minimum(g * squares / np.maximum(traces, 1e-300), largest)
        v = np.array(
            [a * np.sqrt((Pr @ K @ Pr) / max(np.sum(P * K), 1e-300)) for a, K in zip(v, kernels, strict=True)]
        )
        s = max(s * np.sqrt((Pr @ Pr) / np.trace(P)), least)
        left = g[owner] > _NOTHING * len(r) * s
        X, owner = X[:, left], owner[left]
    P = _inverse(s, v, kernels, X * np.sqrt(g[owner]), Q)
    kept, widths = np.unique(owner, return_counts=True)
    significance = np.array([_significance(X[:, owner == k], P, r, float(g[k])) for k in kept])
    return SparseRegression(s, scale * v, kept, significance, widths)


def _inverse(s: float, v: Array, kernels: Sequence[Array], X: Array, Q: Array) -> Array:
    """Return ``P`` ``(n, n)``, the inverse covariance of rows given Q; X has columns of unit variance."""
    C = (
        X @ X.T
        + s * np.eye(len(X))
        + sum((a * K for a, K in zip(v, kernels, strict=True)), np.zeros((len(X), len(X))))
    )
    inverse = linalg.cho_solve(linalg.cho_factor(C), np.eye(len(X)))
    across = inverse @ Q
    # Q is orthonormal only together with its rows on priors, whose variance is one.
    gram = Q.T @ across + np.eye(Q.shape[1]) - Q.T @ Q
    return inverse - across @ np.linalg.solve(gram, across.T)


def _significance(X: Array, P: Array, r: Array, g: float) -> float:
    """Return ``c' S^-1 c`` with ``c = g X' P r`` and ``S = g I - g^2 X' P X``, whose eigenvalues may vanish by rounding."""
    values, vectors = np.linalg.eigh(X.T @ P @ X)
    left = np.maximum(1.0 - g * values, _ROUNDING)
    return float(g * np.sum((vectors.T @ (X.T @ (P @ r))) ** 2 / left))


def _orthonormal(Q: Array, groups: Sequence[Array], seen: float) -> tuple[Array, Array, Array]:
    """Return the groups' columns given Q, orthonormal within each group and side by side ``(n, e)``, and the group of each ``(e,)``.

    The third result is the largest plausible variance of each group ``(K,)``. Directions in which even the largest coefficients stay within
    the noise are left out.
    """
    columns, owner, largest = [np.zeros((len(Q), 0))], [np.zeros(0, dtype=int)], np.zeros(len(groups))
    for k, group in enumerate(groups):
        U, sizes, _ = np.linalg.svd(group - Q @ (Q.T @ group), full_matrices=False)
        left = sizes > max(seen * np.linalg.norm(group, axis=0).max(initial=0.0), 1.0)
        columns.append(U[:, left])
        owner.append(np.full(int(left.sum()), k))
        largest[k] = np.mean(sizes[left] ** 2) if left.any() else 0.0
    return np.concatenate(columns, axis=1), np.concatenate(owner), largest
