"""The normal equations of a model's rows, several times faster than an orthogonal factorisation, which is used where they are too inaccurate.

``J'J`` has the square of the condition number of J. What is computed here is None if that leaves fewer than about eight digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs  # pyright: ignore[reportAttributeAccessIssue]

from scalar.geometry.se3 import Array

# Largest condition number of J'J with unit columns: of some sixteen digits, half are then lost.
_WELL_CONDITIONED = 1e8
_ROUNDING = 1e-11  # of the trace of J'J: more than rounding errors change an eigenvalue


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """``J'J`` and ``J'r`` of whitened rows by F coordinates.

    Attributes:
        gram: ``(F, F)``, ``J'J``.
        gradient: ``(F,)``, ``J'r``.
        squares: ``r'r``.
        rows: Number of rows.
    """

    gram: Array
    gradient: Array
    squares: float
    rows: int

    @classmethod
    def of(cls, residual: Array, J: Array) -> NormalEquations:
        """Return the normal equations of rows ``(R,)`` with the Jacobian ``(R, F)``."""
        return cls(J.T @ J, J.T @ residual, float(residual @ residual), len(residual))

    def with_priors(self, index: Array, residual: Array, slope: Array) -> NormalEquations:
        """Return them with k more rows, each of one coordinate.

        Args:
            index: ``(k,)``, of the coordinate of each row.
            residual: ``(k,)``.
            slope: ``(k,)``, derivative of each row by its coordinate.
        """
        gram, gradient = self.gram.copy(), self.gradient.copy()
        gram[index, index] += slope**2
        gradient[index] += slope * residual
        return NormalEquations(
            gram, gradient, self.squares + float(residual @ residual), self.rows + len(index)
        )

    def variances(self) -> Array | None:
        """Return the diagonal of ``(J'J)^-1`` ``(F,)``; None if J'J is too ill-conditioned."""
        found = _factored(self.gram)
        if found is None:
            return None
        factor, scale = found
        return np.diag(dpotri(factor)[0]) * scale**2

    def covariance_and_step(self) -> tuple[Array, float] | None:
        """Return what the function of this name in ``least_squares`` returns, from one factor; None if J'J is too ill-conditioned."""
        found = _factored(self.gram)
        if found is None:
            return None
        factor, scale = found
        upper = dpotri(factor)[0] * (scale[:, None] * scale)
        return upper + np.triu(upper, 1).T, self._step_by(factor, scale)

    def step(self) -> float | None:
        """Return the length of the remaining Gauss-Newton step in standard deviations, as ``covariance_and_step`` counts it; None as above."""
        found = _factored(self.gram)
        if found is None:
            return None
        return self._step_by(*found)

    def _step_by(self, factor: Array, scale: Array) -> float:
        """Return the length of the step by what ``_factored`` returns."""
        g = self.gradient * scale
        rms = np.sqrt(self.squares / max(self.rows, 1))
        return float(np.sqrt(max(g @ dpotrs(factor, g)[0], 0.0))) / max(1.0, float(rms))

    def all_longer(self, scale: Array, least: float) -> bool | None:
        """Return whether each change of length 1 in units of ``scale`` ``(F,)`` moves the rows by more than ``least``; None if rounding decides."""
        gram = self.gram * (scale[:, None] * scale)
        diagonal, margin = np.arange(len(scale)), _ROUNDING * float(np.trace(gram))
        if not np.isfinite(margin):
            return None
        for limit, longer in ((least**2 + margin, True), (least**2 - margin, False)):
            shifted = gram.copy()
            shifted[diagonal, diagonal] -= limit
            if (dpotrf(shifted)[1] == 0) is longer:
                return longer
        return None


def solved(gram: Array, right: Array) -> tuple[Array, Array]:
    """Return ``A^-1 b`` ``(F,)`` and the diagonal of ``A^-1`` ``(F,)`` of a positive definite matrix A ``(F, F)`` and a vector b ``(F,)``."""
    factor, failed = dpotrf(gram)
    if failed:
        inverse = np.linalg.inv(gram)
        return inverse @ right, inverse.diagonal()
    return dpotrs(factor, right)[0], dpotri(factor)[0].diagonal()


def _factored(gram: Array) -> tuple[Array, Array] | None:
    """Return the upper Cholesky factor of J'J ``(F, F)`` with unit columns, and their scale ``(F,)``; None if the condition number is large."""
    lengths = np.sqrt(gram.diagonal())
    if not (len(lengths) and np.all(np.isfinite(lengths)) and np.all(lengths > 0)):
        return None
    scale = 1.0 / lengths
    scaled = gram * (scale[:, None] * scale)
    factor = factor_if_conditioned(scaled, _WELL_CONDITIONED)
    return None if factor is None else (factor, scale)


def factor_if_conditioned(gram: Array, most: float) -> Array | None:
    """Return the upper Cholesky factor ``(F, F)`` of a matrix ``(F, F)`` for ``solved_by``; None if its condition number may exceed ``most``.

    It is bounded from above by the trace of the matrix times that of its inverse.
    """
    factor, failed = dpotrf(gram, clean=True)
    if failed:
        return None
    condition = float(np.trace(gram)) * float(np.trace(dpotri(factor)[0]))
    return factor if condition < most else None


def solved_by(factor: Array, right: Array) -> Array:
    """Return the solution ``(F,)`` of normal equations with a Cholesky factor ``(F, F)`` and a right-hand side ``(F,)``."""
    return dpotrs(factor, right)[0]
