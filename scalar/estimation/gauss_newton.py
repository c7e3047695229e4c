"""Gauss-Newton steps by normal equations, for a fit that starts near its optimum; they take a small part of the time of ``least_squares.fit``."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs  # pyright: ignore[reportAttributeAccessIssue]  # made by f2py

from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

_STEPS = 10  # largest number of steps; usually three suffice
_LEAST_DROP = 1e-8  # a step that is expected to lower the cost by a smaller share of the residual's mean square (at least 1) is the last
_LEAST_EIGENVALUE = (
    1e-11  # as a share of the largest: with a smaller one, normal equations lose too many digits
)
_CLEARLY = (
    1e-3  # of the largest condition number: with a smaller one, rounding errors cannot matter to the decision
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
        step = solved(gram, projection, _LEAST_EIGENVALUE)
        if step is None:
            break
        vector = model.vector.copy()
        vector[free] -= step / scale
        model = model.with_vector(vector)
        expected_drop = float(projection @ step)
        if expected_drop < _LEAST_DROP * max(1.0, cost / max(len(residual), 1)):
            return model
    return fit(residuals, start, free, tolerance=_TOLERANCE).model


def solved(gram: Array, projection: Array, least: float) -> Array | None:
    """Return ``gram^-1 projection`` ``(F,)``; None if F is 0, or if the least eigenvalue is smaller than the share ``least`` of the largest.

    The norm of the inverse and the trace bound the eigenvalues, which are computed only where these bounds leave it open.

    Args:
        gram: ``(F, F)``, symmetric.
        projection: ``(F,)``.
        least: Share of the largest eigenvalue.
    """
    if not len(gram):
        return None
    factor, failed = dpotrf(gram)
    if not failed:
        inverse, _ = dpotri(factor)  # its upper triangle
        bound = np.sqrt(2.0) * np.linalg.norm(inverse) * np.trace(gram)
        if bound < _CLEARLY / least:
            return dpotrs(factor, projection)[0]
    values, vectors = np.linalg.eigh(gram)
    return None if values[0] < least * values[-1] else vectors @ ((vectors.T @ projection) / values)
