"""Compute how well any poses can separate two causes: a bound that no choice of a given number of candidate poses exceeds.

The noncentrality ``lambda(w) = min_r (c, r)' M(w) (c, r)`` with ``M(w) = M_0 + sum_i w_i A_i' A_i`` is a minimum of functions that are linear in the
weights w, and so concave. Its maximum over ``0 <= w <= 1, sum w = count`` is not below that of any choice of poses. The method of Frank and Wolfe
(1956) climbs towards it, and gives at every step a bound on how far above its present value the maximum may be.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array
from scalar.planning.separation import Question

_STEPS = 300  # most steps of the search
_GAP = 0.01  # relative difference of bound and value at which the search ends


def best_noncentrality(question: Question, start: Array, rows: Array, count: int) -> float:
    """Return a noncentrality (dimensionless) that no choice of ``count`` candidates exceeds.

    Args:
        question: The question that the candidates are to answer.
        start: ``(P, P)``, information of the poses that were measured.
        rows: ``(N, m, P)``, whitened rows of the Jacobian for each of the N candidates.
        count: Number of candidates that are added.
    """
    rest = question.rest.astype(int)
    index = np.r_[question.own, rest].astype(int)
    k = len(question.own)
    A, M0, c = rows[:, :, index], start[np.ix_(index, index)], question.size
    count = min(count, len(A))
    w = np.full(len(A), count / len(A))
    bound = np.inf
    for step in range(_STEPS):
        M = M0 + np.einsum("i,imp,imq->pq", w, A, A, optimize=True)
        v = np.concatenate([c, -np.linalg.solve(M[k:, k:], M[k:, :k] @ c)])
        value = float(v @ M @ v)
        gradient = np.sum((A @ v) ** 2, axis=1)
        best = np.argpartition(gradient, -count)[-count:]
        gap = float(gradient[best].sum() - w @ gradient)
        bound = min(bound, value + gap)
        if bound - value < _GAP * value:
            break
        corner = np.zeros(len(A))
        corner[best] = 1.0
        w += 2 / (step + 3) * (corner - w)
    return bound
