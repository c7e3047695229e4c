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
from typing import Any

import numpy as np
from scipy.linalg import get_lapack_funcs

from scalar.geometry.se3 import Array

_STEPS = 40  # further steps only sharpen variances, and the groups are tested again
_ROUNDING = 1e-10  # least variance of the rows over their mean square, and of a coefficient over its variance before: below, digits run out
_CHOLESKY: Any = get_lapack_funcs(("potrf", "potri"))
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
    kernels = [a * D @ np.swapaxes(D, 1, 2) for a, D in zip(scale, common, strict=True)]
    power = float(r @ r) / len(r)
    least = max(least_variance, _ROUNDING * power)
    s, v = max(0.5 * power, least), np.full(len(kernels), 0.25 * power)
    g = np.minimum(power * len(r) / max(len(groups), 1), largest)
    for _ in range(_STEPS):
        P = _Inverse.of(_block(s, v, kernels, rows.shape), X, g[owner], Q, r)
        squares, traces = (
            np.bincount(owner, values, len(groups))
            for values in ((P.X.T @ r) ** 2, np.einsum("nk,nk->k", X, P.X))
        )
        g = np.minimum(g * squares / np.maximum(traces, 1e-300), largest)
        by_pose = P.r.reshape(rows.shape)
        v = np.array(
            [
                a * np.sqrt(np.einsum("ni,nij,nj->", by_pose, K, by_pose) / max(np.sum(P.blocks * K), 1e-300))
                for a, K in zip(v, kernels, strict=True)
            ]
        )
        s = max(s * np.sqrt((P.r @ P.r) / np.trace(P.blocks, axis1=1, axis2=2).sum()), least)
        left = g[owner] > _NOTHING * len(r) * s
        X, owner = X[:, left], owner[left]
    P = _Inverse.of(_block(s, v, kernels, rows.shape), X, g[owner], Q, r)
    kept, widths = np.unique(owner, return_counts=True)
    significance = np.array(
        [_significance(X[:, owner == k], P.X[:, owner == k], r, float(g[k])) for k in kept]
    )
    return SparseRegression(s, scale * v, kept, significance, widths)


def _block(s: float, v: Array, kernels: Sequence[Array], shape: tuple[int, ...]) -> Array:
    """Return the covariance ``(N, m, m)`` of the rows of each pose by their own noise and those common to a pose."""
    N, m = shape
    return s * np.broadcast_to(np.eye(m), (N, m, m)) + sum(
        (a * K for a, K in zip(v, kernels, strict=True)), np.zeros((N, m, m))
    )


@dataclass(frozen=True, eq=False)
class _Inverse:
    """What is needed of P, the inverse covariance ``(n, n)`` of rows given Q.

    Attributes:
        r: ``P r`` ``(n,)``.
        X: ``P X`` ``(n, e)``.
        blocks: ``(N, m, m)``, of P on its diagonal.
    """

    r: Array
    X: Array
    blocks: Array

    @classmethod
    def of(cls, B: Array, X: Array, g: Array, Q: Array, r: Array) -> _Inverse:
        """Return what is needed for the covariance ``B + X diag(g) X'``, by whichever of rows and columns there are fewer of.

        Args:
            B: ``(N, m, m)``, its part that is a block for each pose.
            X: ``(n, e)``.
            g: ``(e,)``, the variance of each column's coefficient.
            Q: ``(n, F)``, orthonormal only together with its rows on priors, whose variance is one.
            r: ``(n,)``, the rows.
        """
        few = X.shape[1] + Q.shape[1] < len(X)
        return cls._by_columns(B, X, g, Q, r) if few else cls._by_rows(B, X, g, Q, r)

    @classmethod
    def _by_rows(cls, B: Array, X: Array, g: Array, Q: Array, r: Array) -> _Inverse:
        N, m, _ = B.shape
        each = np.arange(N)
        scaled = X * np.sqrt(g)
        C = scaled @ scaled.T
        by_pose = C.reshape(N, m, N, m)
        by_pose[each, :, each] += B
        inverse = _inverse(C)
        across = inverse @ Q
        P = inverse - across @ np.linalg.solve(Q.T @ across + _of_priors(Q), across.T)
        return cls(P @ r, P @ X, P.reshape(N, m, N, m)[each, :, each])

    @classmethod
    def _by_columns(cls, B: Array, X: Array, g: Array, Q: Array, r: Array) -> _Inverse:
        """With ``W = B^-1``, ``T = [X sqrt(g), Q]`` and ``A = T' W T + diag(I, I - Q'Q)``: ``P = W - W T A^-1 T' W`` (Woodbury).

        On the columns themselves ``P X sqrt(g) = (W T A^-1)_X``, in which nothing cancels.
        """
        N, m, _ = B.shape
        e, root = X.shape[1], np.sqrt(g)
        W = np.linalg.inv(B)
        T = np.concatenate([X * root, Q], axis=1)
        WT = (W @ T.reshape(N, m, -1)).reshape(len(T), -1)
        A = T.T @ WT
        A[:e, :e] += np.eye(e)
        A[e:, e:] += _of_priors(Q)
        across = WT @ _inverse((A + A.T) / 2)
        Wr = (W @ r.reshape(N, m, 1)).ravel()
        blocks = W - across.reshape(N, m, -1) @ np.swapaxes(WT.reshape(N, m, -1), 1, 2)
        return cls(Wr - across @ (WT.T @ r), across[:, :e] / np.where(root > 0, root, 1.0), blocks)


def _of_priors(Q: Array) -> Array:
    """Return what the rows on priors add to ``Q'Q`` ``(F, F)``."""
    return np.eye(Q.shape[1]) - Q.T @ Q


def _inverse(A: Array) -> Array:
    """Return the inverse of a symmetric positive definite matrix ``(n, n)``."""
    factorise, invert = _CHOLESKY
    factor, failed = factorise(A, lower=True)
    if failed:
        raise np.linalg.LinAlgError("the covariance is not positive definite")
    lower = np.tril(invert(factor, lower=True)[0])
    return lower + np.tril(lower, -1).T


def _significance(X: Array, PX: Array, r: Array, g: float) -> float:
    """Return ``c' S^-1 c`` with ``c = g X' P r`` and ``S = g I - g^2 X' P X``, whose eigenvalues may vanish by rounding."""
    values, vectors = np.linalg.eigh(X.T @ PX)
    left = np.maximum(1.0 - g * values, _ROUNDING)
    return float(g * np.sum((vectors.T @ (PX.T @ r)) ** 2 / left))


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
