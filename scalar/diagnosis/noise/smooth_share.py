"""Estimate which share of the variance of a scatter between poses belongs to an error that is nearly the same at poses near one another.

The errors e_i that a variance component describes at pose i have the covariance ``v ((1 - s) d_ij + s k_ij)``, where d_ij is 1 if i = j and else 0,
the correlation k_ij of the smooth error falls with the distance of the poses, and s is the share of the variance that varies smoothly. The estimate
of s is one step of scoring on the restricted likelihood from s = 0 (as in ``restricted_likelihood``). With ``u_i = D_i' (P r)_i``, ``G_ij = D_i' P_ij
D_j`` and the matrix K of k, without its diagonal,

    s = (u' K u - tr(K G)) / (v tr(K G K G)),    var(s) = 2 / (v^2 tr(K G K G))    if the errors are random.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent, directions
from scalar.diagnosis.noise.restricted_likelihood import Projection
from scalar.geometry.se3 import Array

MOST_SMOOTH_SHARE = 0.5  # chosen: with a larger share, the larger part of the variance is no random error
MOST_POSES = 300  # chosen: as many as callers should look at, since the time grows with their third power


def smooth_shares(
    state: FittedState, component: VarianceComponent, poses: Array, correlations: Sequence[Array]
) -> list[tuple[float, float]]:
    """Return the share of a component's variance that varies smoothly, and its standard error, infinite if no poses are near one another.

    There is a share for each correlation. It is an estimate without bounds: that of a random error scatters about zero.

    Args:
        state: The state with all effects that were found.
        component: The component.
        poses: ``(n,)``, the indices of the poses that are compared.
        correlations: Matrices ``(n, n)``: the correlation of a smooth error at two of these poses, from 0 to 1. The diagonals are not used.
    """
    background = state.background_within_scans()
    about = Projection.of(background, np.linalg.inv(component.covariance))
    by_error = dict(directions(state.residuals, state.model))[component.name]
    N, m = background.residual.shape
    D, W = by_error[poses], about.W[poses]
    u = np.einsum("nmk,nm->nk", D, about.residual.reshape(N, m)[poses])
    explained = np.einsum("pnm,nmk->pnk", about.half.reshape(-1, N, m)[:, poses], D)
    G = -np.einsum("pik,pjl->ikjl", explained, explained)
    each = np.arange(len(poses))
    G[each, :, each, :] += np.einsum("nmk,nmo,nol->nkl", D, W, D)
    return [_share(u, G, K * (1.0 - np.eye(len(poses))), component.std) for K in correlations]


def _share(u: Array, G: Array, K: Array, std: float) -> tuple[float, float]:
    """Return the share and its standard error by the formulas above.

    Args:
        u: ``(n, k)``, of the k directions in which the component acts at each pose.
        G: ``(n, k, n, k)``.
        K: ``(n, n)``, correlations with zeros on the diagonal.
        std: Standard deviation of the component, the square root of v.
    """
    KG = np.einsum("ij,jkol->ikol", K, G, optimize=True)
    information = std**2 * float(np.einsum("ikjl,jlik->", KG, KG, optimize=True))
    if information <= 0.0:
        return 0.0, np.inf
    score = float(np.einsum("ik,ij,jk->", u, K, u, optimize=True) - np.einsum("ikik->", KG))
    return score / information, float(np.sqrt(2.0 / information) / std)
