"""The upper tail of ``sum p_ik s_i s_k`` over pairs of poses, where the signs s of the poses are random: +1 or -1 with equal probability.

It is computed by the saddlepoint approximation of Lugannani and Rice from the sum's cumulants up to the fourth (Easton and Ronchetti, JASA 81,
1986). With A the symmetric matrix of p, the second to fourth cumulants are ``sum p^2``, ``tr A^3`` and
``3 tr A^4 - 6 sum_i (sum_k p_ik^2)^2 + 4 sum p^4``. Triangles of neighbours make the sum skew, and cycles of four make its tails heavy.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.sparse import coo_array
from scipy.special import ndtr

from scalar.geometry.se3 import Array

# Largest saddlepoint [standard deviations]; the probability of larger sums is returned as 0.
_FARTHEST = 40.0


def upper_tail(products: Array, pairs: Array, n_poses: int) -> float:
    """Return the probability that random signs give a sum at least as large as the sum of the products (all signs equal).

    Args:
        products: ``(P,)``, p of every pair.
        pairs: ``(P, 2)``, the pairs of poses.
        n_poses: Number of poses.
    """
    size = float(np.sqrt(np.sum(products**2)))
    if size == 0.0:
        return 1.0
    value = float(products.sum()) / size
    k3, k4 = _cumulants(products / size, pairs, n_poses)
    if value <= 0.0:
        return float(ndtr(-value))

    def slope(t: float) -> float:
        """Return the derivative of the cumulant generating function K of the sum of unit variance."""
        return t + k3 * t**2 / 2.0 + k4 * t**3 / 6.0

    if slope(_FARTHEST) <= value:
        return 0.0
    t = float(brentq(lambda t: slope(t) - value, 0.0, _FARTHEST, xtol=1e-12))  # type: ignore[arg-type]
    K = t**2 / 2.0 + k3 * t**3 / 6.0 + k4 * t**4 / 24.0
    r = np.sqrt(2.0 * (t * value - K))
    u = t * np.sqrt(1.0 + k3 * t + k4 * t**2 / 2.0)
    return float(ndtr(-(r + np.log(u / r) / r)))


def _cumulants(p: Array, pairs: Array, n_poses: int) -> tuple[float, float]:
    """Return the third and the fourth cumulant of a sum of unit variance.

    A negative cumulant is replaced by zero, so that the tail is never taken to be lighter than that of the normal distribution.
    """
    upper = coo_array((p, (pairs[:, 0], pairs[:, 1])), shape=(n_poses, n_poses))
    A = (upper + upper.T).tocsr()
    AA = A @ A
    sums_of_squares = np.asarray(A.multiply(A).sum(axis=1)).ravel()  # of the pairs of each pose
    third = float(AA.multiply(A).sum())
    fourth = 3.0 * float(AA.multiply(AA).sum()) - 6.0 * np.sum(sums_of_squares**2) + 4.0 * np.sum(p**4)
    return max(third, 0.0), max(float(fourth), 0.0)
