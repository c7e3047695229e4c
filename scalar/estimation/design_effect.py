"""The design effect of a misfit: by how much more variable the estimates are because the residuals of similar poses are correlated.

A model that lacks something leaves a residual that is systematic: the residuals of poses with similar joint angles are correlated. Many such poses
then determine less than their number says. With the scores ``g_k`` of groups of similar poses (sums of the derivatives of their squared residuals),
and F the information matrix, the covariance of the estimates is ``F^-1 (sum g_k g_k') F^-1`` (Liang and Zeger, Biometrika 73, 1986); it is
``F^-1`` if the residuals are independent. The design effect is the mean ratio of the two over all directions (Kish, Survey Sampling, 1965). The fit
takes up a part of each group's score. This is corrected exactly, so that independent residuals have a design effect of one on average (Bell and
McCaffrey, Survey Methodology 28, 2002).
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtrc  # what scipy.stats.chi2.sf calls, without its checks of arrays

from scalar.data.poses import Poses
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS
from scalar.geometry.se3 import Array

# Largest number of groups of similar poses: five halvings. A variance that is estimated from thirty samples has a standard error of a quarter. With
# 16 or 64 groups the results on measured grids are about the same.
GROUPS = 32
LEAST_POSES = 6  # in a group; in smaller groups, similar poses would often be in different groups
# A diagnosis asks for the groups of the same poses at each of its fits.
_GROUPS_OF: WeakKeyDictionary[Poses, Array] = WeakKeyDictionary()
_LEAST_DIAGONAL = 1e-8  # of a triangular factor, as a share of the largest: with a smaller one, dividing by it loses too many digits


def design_effect(
    residuals: Residuals,
    model: Model,
    free: Array,
    ratio: float,
    least_p_value: float = DEFAULTS.fit.misfit_p_value,
    group: Array | None = None,
) -> float:
    """Return the design effect, a ratio of variances of at least 1; it is 1 if chance explains it, or if there are too few poses to judge.

    Args:
        residuals: The residuals of the dataset.
        model: The fitted model.
        free: ``(P,)`` bool, the parameters that were fitted.
        ratio: RMS of the whitened residual over that of the noise; the residuals are divided by it.
        least_p_value: The design effect is 1 unless its p-value for independent residuals is smaller than this.
        group: ``(N,)``, the group of each pose, from 0; groups of similar poses if None.
    """
    if group is None:
        poses = residuals.poses
        if poses not in _GROUPS_OF:
            _GROUPS_OF[poses] = similar_poses(poses.q, GROUPS, LEAST_POSES)
        group = _GROUPS_OF[poses]
    n_groups = int(group.max()) + 1
    if n_groups < 2:
        return 1.0
    residual, jacobian = residuals.linearise(model)
    scale = np.linalg.norm(jacobian[:, free], axis=0)
    Q = _orthonormal(jacobian[:, free] / np.where(scale == 0, 1.0, scale))
    N, m = len(group), residuals.measurement.rows_per_pose
    Q_poses, r_poses = Q[: N * m].reshape(N, m, -1), residual[: N * m].reshape(N, m) / ratio
    rows = [Q_poses[group == k].reshape(-1, Q.shape[1]) for k in range(n_groups)]
    scores = np.stack([A.T @ r_poses[group == k].ravel() for k, A in enumerate(rows)])
    # Priors shift the optimum, and so the scores, without any misfit. The scores are therefore moved to the optimum of the data alone. With A the
    # rows of a group's poses, H = A'A is their information matrix and S the sum of all H. If residuals are independent, the group's score has the
    # covariance B = H - H S^+ H there.
    information = np.eye(Q.shape[1]) - Q[N * m :].T @ Q[N * m :]
    inverse = np.linalg.pinv(information, rcond=1e-8, hermitian=True)
    shift = inverse @ scores.sum(axis=0)
    scores -= np.stack([A.T @ (A @ shift) for A in rows])
    traces = np.array([_traces(A, inverse) for A in rows])
    expected, variance = float(traces[:, 0].sum()), 2.0 * float(traces[:, 1].sum())
    found = float(np.sum(scores * scores))
    if expected <= 0 or variance <= 0:
        return 1.0
    # Satterthwaite's approximation: ``found`` is distributed as a multiple of a chi-squared variable with this expectation and variance.
    degrees_of_freedom = 2.0 * expected**2 / variance
    p_value = float(chdtrc(degrees_of_freedom, degrees_of_freedom * found / expected))
    return max(found / expected, 1.0) if p_value < least_p_value else 1.0


def standstills(q: Array, order: Array) -> Array:
    """Return the index ``(N,)`` of the standstill in which each row was read, from 0: rows that follow one another with equal joint angles share one.

    Args:
        q: Joint angles ``(N, n)`` [rad, or m of a joint that slides].
        order: ``(N,)``, the order of acquisition.
    """
    rows = np.argsort(order, kind="stable")
    moved = np.any(np.diff(q[rows], axis=0) != 0, axis=1)
    standstill = np.zeros(len(q), dtype=int)
    standstill[rows[1:]] = np.cumsum(moved)
    return standstill


def _traces(A: Array, inverse: Array) -> tuple[float, float]:
    """Return the traces of B and of B B, where ``B = A' (I - A S^+ A') A``.

    They are those of products of the smaller of two matrices, ``(R, R)`` or ``(F, F)``.

    Args:
        A: ``(R, F)``.
        inverse: ``(F, F)``, S^+.
    """
    if len(A) < A.shape[1]:
        product = (np.eye(len(A)) - A @ inverse @ A.T) @ (A @ A.T)
    else:
        H = A.T @ A
        product = H - H @ inverse @ H
    return float(np.trace(product)), float(np.sum(product * product.T))


def _orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis ``(R, F)`` of columns ``(R, F)``; where they are clearly independent, by division by their triangular factor."""
    factor = np.asarray(np.linalg.qr(columns, mode="r"))
    sizes = np.abs(np.diag(factor))
    if len(factor) < columns.shape[1] or sizes.min(initial=1.0) <= _LEAST_DIAGONAL * sizes.max(initial=1.0):
        return np.linalg.qr(columns)[0]
    return solve_triangular(factor, columns.T, trans=1, check_finite=False).T


def similar_poses(q: Array, most: int, least: int) -> Array:
    """Return the index of the group of every pose, ``(N,)``, from 0.

    Each step takes the group and the joint with the largest range of angles, and halves this group at the median of this joint.

    Args:
        q: Joint angles ``(N, n)`` [rad].
        most: Largest number of groups.
        least: Least number of poses in a group.
    """

    def ranges(rows: Array) -> Array:
        """Return the range of every joint in a group; zero for a group that is too small to be halved."""
        return np.ptp(q[rows], axis=0) if len(rows) >= 2 * least else np.zeros(q.shape[1])

    groups = [np.arange(len(q))]
    widths = [ranges(groups[0])]
    while len(groups) < most:
        widest = int(np.argmax([of_group.max(initial=0.0) for of_group in widths]))
        joint = int(np.argmax(widths[widest]))
        if widths[widest][joint] == 0:
            break
        rows, _ = groups.pop(widest), widths.pop(widest)
        rows = rows[np.argsort(q[rows, joint], kind="stable")]
        halves = [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
        groups += halves
        widths += [ranges(half) for half in halves]
    group = np.zeros(len(q), dtype=int)
    for k, rows in enumerate(groups):
        group[rows] = k
    return group
