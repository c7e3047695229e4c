"""The design effect of a misfit: by how much more variable the estimates are because the residuals of similar poses are correlated.

A model that lacks something leaves a residual that is systematic: the residuals of poses with similar joint angles are correlated. Many such poses
then determine less than their number says. With the scores ``g_k`` of groups of similar poses (sums of the derivatives of their squared residuals),
the variance of an estimate is ``F^-1 (sum g_k g_k') F^-1`` (Liang and Zeger, Biometrika 73, 1986), where independent residuals have ``F^-1``. The
design effect is the mean ratio of the two over all directions (Kish, Survey Sampling, 1965). The fit takes up a part of each group's score, which
is corrected exactly: independent residuals have a design effect of one on average (Bell and McCaffrey, Survey Methodology 28, 2002).
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc  # what scipy.stats.chi2.sf calls, without its checks of arrays

from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS
from scalar.geometry.se3 import Array

GROUPS = 32  # of similar poses: five halvings; a variance of thirty samples is known to a quarter. 16 and 64 do about the same on measured grids
LEAST_POSES = 6  # of a group: with fewer, similar poses are hardly in one group


def design_effect(
    residuals: Residuals,
    model: Model,
    free: Array,
    ratio: float,
    least_p_value: float = DEFAULTS.fit.misfit_p_value,
) -> float:
    """Return the design effect: 1 if chance explains it, or if there are too few poses to judge.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        free: ``(P,)`` bool.
        ratio: Of the residual to the noise.
        least_p_value: With a larger p-value, independent residuals explain what the groups show.
    """
    group = similar_poses(residuals.poses.q, GROUPS, LEAST_POSES)
    n_groups = int(group.max()) + 1
    if n_groups < 2:
        return 1.0
    residual, jacobian = residuals.linearise(model)
    scale = np.linalg.norm(jacobian[:, free], axis=0)
    Q = np.linalg.qr(jacobian[:, free] / np.where(scale == 0, 1.0, scale))[0]
    N, m = len(group), residuals.measurement.rows_per_pose
    of_pose = Q[: N * m].reshape(N, m, -1)
    scores = np.zeros((n_groups, Q.shape[1]))
    np.add.at(scores, group, np.einsum("nmp,nm->np", of_pose, residual[: N * m].reshape(N, m)) / ratio)
    # What priors pull the scores by is no misfit: they are taken at the optimum of the data alone. There, a group's score has the covariance
    # B = H - H S^+ H if residuals are independent, with H what its poses determine of each direction, and S the sum of all H.
    H = np.stack([(rows := of_pose[group == k].reshape(-1, Q.shape[1])).T @ rows for k in range(n_groups)])
    inverse = np.linalg.pinv(H.sum(axis=0), rcond=1e-8, hermitian=True)
    scores -= np.einsum("gij,j->gi", H, inverse @ scores.sum(axis=0))
    B = H - H @ inverse @ H
    mean = float(np.trace(B, axis1=1, axis2=2).sum())
    variance = 2.0 * float(np.sum(B * B))
    found = float(np.sum(scores * scores))
    if mean <= 0 or variance <= 0:
        return 1.0
    # Satterthwaite's approximation: the sum is distributed as a multiple of a chi-squared variable with this mean and variance.
    freedom = 2.0 * mean**2 / variance
    chance = float(chdtrc(freedom, freedom * found / mean))
    return max(found / mean, 1.0) if chance < least_p_value else 1.0


def similar_poses(q: Array, most: int, least: int) -> Array:
    """Return the group ``(N,)`` of every pose: the poses are halved again and again along the joint that spreads most in a group.

    Args:
        q: Joint angles ``(N, n)`` [rad].
        most: Groups.
        least: Poses of a group.
    """
    groups = [np.arange(len(q))]
    while len(groups) < most:
        spreads = [
            np.ptp(q[rows], axis=0) if len(rows) >= 2 * least else np.zeros(q.shape[1]) for rows in groups
        ]
        widest = int(np.argmax([spread.max(initial=0.0) for spread in spreads]))
        joint = int(np.argmax(spreads[widest]))
        if spreads[widest][joint] == 0:
            break
        rows = groups.pop(widest)
        rows = rows[np.argsort(q[rows, joint], kind="stable")]
        groups += [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
    group = np.zeros(len(q), dtype=int)
    for k, rows in enumerate(groups):
        group[rows] = k
    return group
