"""Gauss-Newton steps by normal equations, for a fit that starts near its optimum; they take a small part of the time of ``least_squares.fit``.

A step that raises the cost is taken again with damping (Levenberg, Quarterly of Applied Mathematics 2, 1944; Marquardt, Journal of the Society for
Industrial and Applied Mathematics 11, 1963). How the damping rises and falls is Nielsen's rule (Damping parameter in Marquardt's method, report
IMM-REP-1999-05, Technical University of Denmark, 1999): it falls by at most three after a step, as far as the step did what was expected of it, and
rises by two, four, eight and so on while steps fail.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.normal_equations import factor_if_conditioned, solved_by
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

_STEPS = 200  # largest number of steps, those included that raised the cost; usually three suffice
_LEAST_DROP = 1e-6  # a step that is expected to lower the cost by a smaller share of the residual's mean square (at least 1) is the last
# Along a curved valley steps stay short. The last one is then that before which this many others have lowered the cost by less than this many times
# the residual's mean square: the data do not distinguish such models.
_SLOW_STEPS, _SLOW_DROP = 10, 0.1
# Share of the largest eigenvalue: with a smaller one, normal equations lose too many digits.
_LEAST_EIGENVALUE = 1e-11
_CLEARLY_CONDITIONED = 1e9  # condition number below which they certainly lose fewer digits than that
_FIRST_DAMPING = 1e-6  # share of the largest eigenvalue
_LEAST_DAMPING = 1e-10  # the same; a smaller one is none
_MOST_DAMPING = 1e6  # the same; with it steps are lost in rounding
_TOLERANCE = 1e-9  # relative change of cost and coordinates with which the slower fit ends: rounding errors


def optimum_near(residuals: Residuals, model: Model, free: Array) -> Model:
    """Return the optimum near a model by Gauss-Newton steps; by ``fit`` if these do not converge or the equations are ill-conditioned.

    Args:
        residuals: Of the dataset.
        model: Near the optimum; fixed coordinates keep their values.
        free: ``(P,)`` bool.
    """
    start = best = model
    equations: NormalEquations | None = None
    cost, damping, growth = np.inf, 0.0, 2.0
    costs: list[float] = []
    for _ in range(_STEPS):
        residual, jacobian = residuals.linearise(model)
        now = float(residual @ residual)
        if now > cost * (1.0 + 1e-9):
            damping = max(growth * damping, _FIRST_DAMPING)
            growth *= 2.0
        else:
            if equations is not None:
                done = (cost - now) / max(equations.expected_drop(damping), np.finfo(float).tiny)
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * done - 1.0) ** 3)
            damping = damping if damping > _LEAST_DAMPING else 0.0
            best, cost, growth = model, now, 2.0
            costs.append(cost)
            equations = NormalEquations.of(residual, jacobian[:, free])
        if equations is None or damping > _MOST_DAMPING:
            break
        mean_square = max(1.0, cost / max(len(residual), 1))
        if len(costs) > _SLOW_STEPS and costs[-1 - _SLOW_STEPS] - cost < _SLOW_DROP * mean_square:
            return best
        is_last = equations.expected_drop() < _LEAST_DROP * mean_square
        vector = best.vector.copy()
        vector[free] += equations.step(0.0 if is_last else damping)
        model = best.with_vector(vector)
        if is_last:
            return model
    return fit(residuals, start, free, tolerance=_TOLERANCE).model


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """The normal equations of a linearised fit; the columns of the Jacobian have unit length.

    Attributes:
        scale: ``(F,)``, the lengths of the columns; 1 where a column is zero.
        gram: ``(F, F)``, the matrix of the equations.
        gradient: ``(F,)``, the gradient of half the cost.
    """

    scale: Array
    gram: Array
    gradient: Array

    @classmethod
    def of(cls, residual: Array, J: Array) -> NormalEquations | None:
        """Return the equations of a residual ``(R,)`` with derivatives ``(R, F)``; None if they are ill-conditioned or nothing is free."""
        scale = np.linalg.norm(J, axis=0)
        scale[scale == 0] = 1.0
        found = cls(scale, (J.T @ J) / np.outer(scale, scale), (J.T @ residual) / scale)
        if not len(scale):
            return None
        if found._factor is None:
            values = found._spectrum[0]
            if values[0] < _LEAST_EIGENVALUE * values[-1]:
                return None
        return found

    @cached_property
    def _factor(self) -> Array | None:
        """Return the Cholesky factor of the matrix, in a fifth of the time of its eigenvectors; None unless it is clearly well conditioned."""
        return factor_if_conditioned(self.gram, _CLEARLY_CONDITIONED)

    @cached_property
    def _spectrum(self) -> tuple[Array, Array, Array]:
        """Return the eigenvalues ``(F,)`` in ascending order, the eigenvectors ``(F, F)``, and the gradient along each of them ``(F,)``."""
        values, vectors = np.linalg.eigh(self.gram)
        return values, vectors, vectors.T @ self.gradient

    @cached_property
    def _undamped(self) -> Array:
        """Return the step without damping ``(F,)``, for columns of unit length."""
        if self._factor is not None:
            return -solved_by(self._factor, self.gradient)
        values, vectors, along = self._spectrum
        return -(vectors @ (along / values))

    def step(self, damping: float) -> Array:
        """Return the step ``(F,)`` with a damping, as a share of the largest eigenvalue."""
        if not damping:
            return self._undamped / self.scale
        values, vectors, along = self._spectrum
        return -(vectors @ (along / (values + damping * values[-1]))) / self.scale

    def expected_drop(self, damping: float = 0.0) -> float:
        """Return by how much the step with a damping lowers the cost if the fit is linear."""
        if not damping:
            return -float(self.gradient @ self._undamped)
        values, _, along = self._spectrum
        more = damping * values[-1]
        return float(np.sum(along**2 * (values + 2.0 * more) / (values + more) ** 2))
