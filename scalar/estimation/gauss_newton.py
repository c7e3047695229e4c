"""Gauss-Newton steps by normal equations, for a fit that starts near its optimum; they take a small part of the time of ``least_squares.fit``."""

from __future__ import annotations

import numpy as np

from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

_STEPS = 20  # largest number of steps; usually three suffice, and fits of hundreds of coefficients have taken thirteen
_LEAST_DROP = 1e-8  # a step that is expected to lower the cost by a smaller share of the residual's mean square (at least 1) is the last
_LEAST_EIGENVALUE = (
    1e-11  # as a share of the largest: with a smaller one, normal equations lose too many digits
)
_TOLERANCE = 1e-9  # relative change of cost and coordinates with which the slower fit ends: rounding errors


def optimum_near(residuals: Residuals, model: Model, free: Array) -> Model:
    """Return the optimum near a model by Gauss-Newton steps; by ``fit`` if these do not converge or the equations are ill-conditioned.

    Args:
        residuals: Of the dataset.
        model: Near the optimum; fixed coordinates keep their values.
        free: ``(P,)`` bool.
    """
    start = model
    cost = np.inf
    for _ in range(_STEPS):
        residual, jacobian = residuals.linearise(model)
        now = float(residual @ residual)
        if now > cost * (1.0 + 1e-9):
            break
        cost = now
        J = jacobian[:, free]
        scale = np.linalg.norm(J, axis=0)
        scale[scale == 0] = 1.0
        gram, projection = (J.T @ J) / np.outer(scale, scale), (J.T @ residual) / scale
        values, vectors = np.linalg.eigh(gram)
        if len(values) == 0 or values[0] < _LEAST_EIGENVALUE * values[-1]:
            break
        along = vectors.T @ projection
        vector = model.vector.copy()
        vector[free] -= (vectors @ (along / values)) / scale
        model = model.with_vector(vector)
        expected_drop = float(np.sum(along**2 / values))
        if expected_drop < _LEAST_DROP * max(1.0, cost / max(len(residual), 1)):
            return model
    return fit(residuals, start, free, tolerance=_TOLERANCE).model
