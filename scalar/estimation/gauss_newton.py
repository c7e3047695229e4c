"""Gauss-Newton steps by normal equations, for a fit that starts near its optimum; they take a small part of the time of ``least_squares.fit``.

A step that raises the cost is taken again with damping (Levenberg, Quarterly of Applied Mathematics 2, 1944; Marquardt, Journal of the Society for
Industrial and Applied Mathematics 11, 1963). How the damping rises and falls is Nielsen's rule (Damping parameter in Marquardt's method, report
IMM-REP-1999-05, Technical University of Denmark, 1999): it falls by at most three after a step, as far as the step did what was expected of it, and
rises by two, four, eight and so on while steps fail.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

_STEPS = 200  # largest number of steps, those included that raised the cost; usually three suffice
_LEAST_DROP = 1e-6  # a step that is expected to lower the cost by a smaller share of the residual's mean square (at least 1) is the last
# Along a curved valley steps stay short. The last one is then that before which this many others have lowered the cost by less than this many times
# the residual's mean square: the data do not tell such models apart.
_SLOW_STEPS, _SLOW_DROP = 10, 0.1
_LEAST_EIGENVALUE = (
    1e-11  # as a share of the largest: with a smaller one, normal equations lose too many digits
)
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
    """The normal equations of a linearised fit in the coordinates of their eigenvectors; the columns of the Jacobian have unit length.

    Attributes:
        scale: ``(F,)``, the lengths of the columns; 1 where a column is zero.
        values: ``(F,)``, the eigenvalues in ascending order.
        vectors: ``(F, F)``, the eigenvectors.
        along: ``(F,)``, the gradient of half the cost along each eigenvector.
    """

    scale: Array
    values: Array
    vectors: Array
    along: Array

    @classmethod
    def of(cls, residual: Array, J: Array) -> NormalEquations | None:
        """Return the equations of a residual ``(R,)`` with derivatives ``(R, F)``; None if they are ill-conditioned or nothing is free."""
        scale = np.linalg.norm(J, axis=0)
        scale[scale == 0] = 1.0
        values, vectors = np.linalg.eigh((J.T @ J) / np.outer(scale, scale))
        if len(values) == 0 or values[0] < _LEAST_EIGENVALUE * values[-1]:
            return None
        return cls(scale, values, vectors, vectors.T @ ((J.T @ residual) / scale))

    def step(self, damping: float) -> Array:
        """Return the step ``(F,)`` with a damping, as a share of the largest eigenvalue."""
        return -(self.vectors @ (self.along / (self.values + damping * self.values[-1]))) / self.scale

    def expected_drop(self, damping: float = 0.0) -> float:
        """Return by how much the step with a damping lowers the cost if the fit is linear."""
        more = damping * self.values[-1]
        return float(np.sum(self.along**2 * (self.values + 2.0 * more) / (self.values + more) ** 2))
