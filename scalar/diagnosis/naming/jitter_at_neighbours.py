"""Tell a jitter of the joints from an error that varies smoothly with the joint angles, by poses that are near each other.

Where nothing in the model explains the pull of a hose or a floor that gives way, it scatters poses that all differ as a random error of the joints
does. At two poses whose joint angles are near each other, however, such an error is nearly the same, and a jitter is another. Whether the poses are
near enough to show it depends on their number and on the ranges of the joints.

The errors e_i of the joints at pose i have the covariance ``v ((1 - s) d_ij + s k_ij)``, where d_ij is 1 if i = j and else 0, k_ij falls with the
distance of the joint angles, and s is the share of the variance that varies smoothly. The estimate of s is one step of scoring on the restricted
likelihood from s = 0 (as in ``restricted_likelihood``). With ``u_i = D_i' (P r)_i``, ``G_ij = D_i' P_ij D_j`` and the matrix K of k without its
diagonal,

    s = (u' K u - tr(K G)) / (v tr(K G K G)),    var(s) = 2 / (v^2 tr(K G K G))    if the errors are random.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent, directions
from scalar.diagnosis.noise.restricted_likelihood import Projection
from scalar.geometry.se3 import Array

CORRELATION_LENGTH = 1.5  # chosen [rad, or m of a joint that slides]: of one joint; an error of one period a turn falls to zero over this
MOST_SHARE = 0.5  # chosen: with a larger share, the larger part of the scatter is no random error
ONE_SIDED = 1.645  # standard errors: 95 % of a normal variable lies below
MOST_POSES = 300  # chosen: so many are enough, and the time grows with their third power


def excludes_smooth_error(state: FittedState, component: VarianceComponent) -> bool:
    """Return whether neighbouring poses show that less than ``MOST_SHARE`` of a jitter's variance varies smoothly with the joint angles.

    Args:
        state: The state with all effects that were found.
        component: The jitter.
    """
    share, error = state.once(("smooth share", component), lambda: smooth_share(state, component))
    return share + ONE_SIDED * error < MOST_SHARE


def smooth_share(state: FittedState, component: VarianceComponent) -> tuple[float, float]:
    """Return the share of a jitter's variance that varies smoothly with the joint angles, and its standard error, infinite if no poses are near.

    The share is an estimate without bounds: of a random error it scatters about zero.

    Args:
        state: The state with all effects that were found.
        component: The jitter.
    """
    background = state.background_within_scans()
    about = Projection.of(background, np.linalg.inv(component.covariance))
    by_error = dict(directions(state.residuals, state.model))[component.name]
    N, m = background.residual.shape
    seen = np.unique(np.linspace(0, N - 1, min(N, MOST_POSES)).astype(int))
    D, W = by_error[seen], about.W[seen]
    u = np.einsum("nmk,nm->nk", D, about.residual.reshape(N, m)[seen])
    explained = np.einsum("pnm,nmk->pnk", about.half.reshape(-1, N, m)[:, seen], D)
    G = -np.einsum("pik,pjl->ikjl", explained, explained)
    each = np.arange(len(seen))
    G[each, :, each, :] += np.einsum("nmk,nmo,nol->nkl", D, W, D)
    K = _nearness(state.dataset.q[seen])
    KG = np.einsum("ij,jkol->ikol", K, G, optimize=True)
    information = component.std**2 * float(np.einsum("ikjl,jlik->", KG, KG, optimize=True))
    if information <= 0.0:
        return 0.0, np.inf
    score = float(np.einsum("ik,ij,jk->", u, K, u, optimize=True) - np.einsum("ikik->", KG))
    return score / information, float(np.sqrt(2.0 / information) / component.std)


def _nearness(q: Array) -> Array:
    """Return how nearly alike a smooth error is at two poses ``(N, N)``: 1 at the same joint angles, and 0 of a pose with itself.

    Args:
        q: Joint coordinates ``(N, n)`` [rad, or m of a joint that slides].
    """
    apart = np.sum((q[:, None, :] - q[None, :, :]) ** 2, axis=2)
    K = np.exp(-0.5 * apart / CORRELATION_LENGTH**2)
    np.fill_diagonal(K, 0.0)
    return K
