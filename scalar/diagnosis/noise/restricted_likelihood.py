"""Variance components fitted together by restricted likelihood, by steps of average information.

The whitened residual r of all poses has the covariance ``V = I + sum_k v_k K_k``, block by block for each pose, about a model with columns X. With
``P = V^-1 - V^-1 X (X' V^-1 X)^-1 X' V^-1`` the restricted log likelihood (Patterson and Thompson, Biometrika 58, 1971) has

    dL/dv_k = -1/2 [tr(P K_k) - r' P K_k P r],    AI_kl = 1/2 r' P K_k P K_l P r

(Gilmour, Thompson and Cullis, Biometrics 51, 1995). AI is the average information, and a step is ``AI^-1 dL/dv``. The rows of priors are included,
with the covariance I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from scalar.diagnosis.fit.background import Background
from scalar.geometry.se3 import Array

_MOST_STEPS = 40
_CONVERGED = 1e-4  # nats: a step with a smaller gain is the last
_HALVINGS = 12  # most halvings of a step that lowers the likelihood
_LARGEST = 1e8  # largest variance of a scaled component, so that data without noise give finite numbers
# Share of a kernel's mean trace; a smaller median is rounding, and would scale the kernel to infinity.
_LEAST_SHARE = 1e-6


@dataclass(frozen=True, eq=False)
class Components:
    """Components at the optimum.

    Attributes:
        variances: ``(k,)``, not negative.
        std_errors: ``(k,)``, of the variances.
        log_likelihood: Restricted, less a constant that does not depend on the components [nats].
    """

    variances: Array
    std_errors: Array
    log_likelihood: float


@dataclass(frozen=True, eq=False)
class Projection:
    """The matrix P, which weights rows by the inverse of their covariance and removes what the model explains, and the residual under it.

    Attributes:
        W: ``(N, m, m)``, inverses of the covariances of the poses' rows.
        half: ``(p, N m)``, with ``P = W - half' half``.
        residual: ``(N m,)``, P r.
        sum_of_squares: ``r' P r``, the rows of priors left out.
        half_log_determinant: Half the logarithm of the determinant of ``X' W X`` and the rows of priors.
    """

    W: Array
    half: Array
    residual: Array
    sum_of_squares: float
    half_log_determinant: float

    @classmethod
    def of(cls, background: Background, W: Array) -> Projection:
        """Return P for a residual, the directions that the model explains, and the weights W ``(N, m, m)``."""
        r, flat = background.residual, background.Q
        N, m = r.shape
        WX = (W @ flat.reshape(N, m, -1)).reshape(N * m, -1)
        # The residual has no component along Q and its rows on priors together.
        G = flat.T @ WX + background.gram_of_priors
        L = np.linalg.cholesky(G + 1e-12 * np.eye(len(G)))
        half = solve_triangular(L, WX.T, lower=True, check_finite=False)
        Wr = (W @ r.reshape(N, m, 1)).reshape(-1)
        along = solve_triangular(L, flat.T @ (Wr - r.ravel()), lower=True, check_finite=False)
        squares = float(r.ravel() @ Wr - np.sum(along**2))
        return cls(W, half, Wr - half.T @ along, squares, float(np.sum(np.log(np.diag(L)))))

    def applied_to(self, x: Array) -> Array:
        """Return ``P x`` ``(N m,)``."""
        weighted = (self.W @ x.reshape(*self.W.shape[:2], 1)).reshape(-1)
        return weighted - self.half.T @ (self.half @ x)


def fit_components(background: Background, kernels: Sequence[Array]) -> Components:
    """Return the variance components of greatest restricted likelihood.

    Args:
        background: The residual, whitened for the noise within poses, and the directions that the model explains.
        kernels: K_k ``(N, m, m)`` each, what a component of unit variance adds to the covariance of each pose's rows.
    """
    scale = np.array([1.0 / _usual_trace(K) for K in kernels])
    scaled = [s * K for s, K in zip(scale, kernels, strict=True)]
    if not kernels:
        return Components(np.zeros(0), np.zeros(0), _evaluate(background, scaled, np.zeros(0))[0])
    starts = [np.full(len(kernels), size) for size in (0.1, 10.0)]
    best = max((_maximised(background, scaled, v) for v in starts), key=lambda found: found.log_likelihood)
    return Components(scale * best.variances, scale * best.std_errors, best.log_likelihood)


def _usual_trace(kernel: Array) -> float:
    """Return the median trace of a kernel ``(N, m, m)``, or the mean where a component moves nothing at half of the poses; 1 where at none."""
    traces = np.trace(kernel, axis1=1, axis2=2)
    usual, mean = float(np.median(traces)), float(np.mean(traces))
    return usual if usual > _LEAST_SHARE * mean else mean if mean > 0 else 1.0


def _maximised(background: Background, kernels: list[Array], v: Array) -> Components:
    """Return the optimum that steps of average information reach from variances v ``(k,)``; no variance becomes negative."""
    value, gradient, information = _evaluate(background, kernels, v)
    for _ in range(_MOST_STEPS):
        free = (v > 0) | (gradient > 0)
        step = np.zeros_like(v)
        if free.any():
            step[free] = np.linalg.lstsq(information[np.ix_(free, free)], gradient[free], rcond=1e-10)[0]
        if float(gradient @ step) < 0:
            step = gradient / np.maximum(np.diag(information), 1e-300) * free
        # In one step a variance grows to ten times its value plus one at most, because the quadratic approximation does not hold farther away.
        step = np.minimum(step, 9.0 * v + 1.0)
        for _halving in range(_HALVINGS):
            trial = np.clip(v + step, 0.0, _LARGEST)
            found = _evaluate(background, kernels, trial)
            if found[0] >= value:
                break
            step = 0.5 * step
        else:
            break
        gained = found[0] - value
        v, (value, gradient, information) = trial, found
        if gained < _CONVERGED:
            break
    inverse = np.linalg.pinv(information, hermitian=True)
    return Components(v, np.sqrt(np.maximum(np.diag(inverse), 0.0)), value)


def _evaluate(background: Background, kernels: list[Array], v: Array) -> tuple[float, Array, Array]:
    """Return the restricted log likelihood, its gradient ``(k,)`` and the average information ``(k, k)`` at variances v ``(k,)``."""
    r = background.residual
    N, m = r.shape
    V = np.broadcast_to(np.eye(m), (N, m, m)) + sum(
        (a * K for a, K in zip(v, kernels, strict=True)), np.zeros((N, m, m))
    )
    determinant = float(np.sum(np.log(np.diagonal(np.linalg.cholesky(V), axis1=1, axis2=2))))
    about = Projection.of(background, np.linalg.inv(V))
    W, half, Pr = about.W, about.half, about.residual
    value = -determinant - about.half_log_determinant - 0.5 * about.sum_of_squares
    blocks = W - np.einsum("fni,fnj->nij", half.reshape(-1, N, m), half.reshape(-1, N, m))
    KPr = [(K @ Pr.reshape(N, m, 1)).reshape(-1) for K in kernels]
    gradient = np.array(
        [-0.5 * (float(np.sum(blocks * K)) - float(Pr @ q)) for K, q in zip(kernels, KPr, strict=True)]
    )
    PKPr = [about.applied_to(q) for q in KPr]
    information = 0.5 * np.array([[float(p @ q) for q in KPr] for p in PKPr])
    return value, gradient, information
