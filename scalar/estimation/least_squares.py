"""One Levenberg-Marquardt run through lmfit: free coordinates of a model, analytic Jacobian, covariance by our own algebra.

``minimise |r(x)|^2`` over the free coordinates; r is whitened, so ``(J' J)^-1`` at the optimum is the covariance. lmfit is
given the free coordinates alone, and its own covariance is not used: on a rank-deficient problem it claims error bars all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import lmfit
import numpy as np

from scalar.estimation.lmfit_parameters import from_lmfit, to_lmfit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

TOLERANCE = 1e-10  # relative, on cost and coordinates; less than that is rounding, and a step for nothing
MAX_EVALUATIONS = 200
FIRST_STEP = (
    0.1  # of the coordinates' own size: the default of MINPACK, 100, lets a weak direction jump by turns
)
RANK_TOLERANCE = 1e-10  # of the largest singular value of the column-scaled Jacobian
NEGLIGIBLE_STEP = 1e-3  # standard deviations: a remaining Gauss-Newton step below this does not matter


@dataclass(frozen=True, eq=False)
class Fit:
    """What a run found.

    Attributes:
        model: At the optimum.
        free: ``(P,)`` bool, which coordinates were free.
        covariance: ``(F, F)`` of the free coordinates, residuals taken as whitened.
        chi_squared: Sum of squared whitened residuals.
        evaluations: Calls of the residual.
        converged: Whether the remaining step is negligible.
        message: lmfit's own words.
    """

    model: Model
    free: Array
    covariance: Array
    chi_squared: float
    evaluations: int
    converged: bool
    message: str


class _Minimizer(lmfit.Minimizer):
    """lmfit's own, without its error bars: they cost more than the residuals, and ours replace them."""

    def _calculate_uncertainties_correlations(self) -> None:
        pass


class _Objective:
    """Residual and Jacobian as functions of the free coordinates, each state computed once."""

    def __init__(self, residuals: Residuals, model: Model, free: Array) -> None:
        self.residuals, self.model = residuals, model
        self.free = np.flatnonzero(free)
        self.start = model.vector
        self.evaluations = 0
        self.latest, self.x_latest = model, self.start[self.free]
        self._linearised: tuple[Model, Array, Array] | None = None

    def at(self, x: Array) -> Model:
        """Return the model at free coordinates; the same object as last time where they have not changed."""
        if not np.array_equal(x, self.x_latest):
            vector = self.start.copy()
            vector[self.free] = x
            self.latest, self.x_latest = self.model.with_vector(vector), x
        return self.latest

    def residual(self, parameters: lmfit.Parameters) -> Array:
        self.evaluations += 1
        return self.residuals.residual(self.at(from_lmfit(parameters)))

    def jacobian(self, parameters: lmfit.Parameters) -> Array:
        return self.linearised(self.at(from_lmfit(parameters)))[1]

    def linearised(self, model: Model) -> tuple[Array, Array]:
        """Return residual and Jacobian by the free coordinates; SciPy asks twice at the start."""
        if self._linearised is None or self._linearised[0] is not model:
            residual, jacobian = self.residuals.linearise(model)
            self._linearised = model, residual, jacobian[:, self.free]
        return self._linearised[1], self._linearised[2]


def fit(residuals: Residuals, model: Model, free: Array, *, tolerance: float = TOLERANCE) -> Fit:
    """Return the least-squares optimum over the free coordinates of a model.

    Args:
        residuals: Of the dataset.
        model: Initial values; fixed coordinates keep them.
        free: ``(P,)`` bool.
        tolerance: Relative, on cost and coordinates.
    """
    objective = _Objective(residuals, model, free)
    x = objective.start[objective.free]
    names = model.names
    minimiser = _Minimizer(
        objective.residual,
        to_lmfit([names[i] for i in objective.free], x),
        scale_covar=False,
        calc_covar=False,
        nan_policy="propagate",
        max_nfev=MAX_EVALUATIONS,
    )
    result: Any = minimiser.leastsq(
        Dfun=objective.jacobian, col_deriv=0, ftol=tolerance, xtol=tolerance, gtol=0.0, factor=FIRST_STEP
    )
    optimum = objective.at(from_lmfit(result.params))
    residual, J = objective.linearised(optimum)
    covariance, step_in_sigmas = covariance_and_step(J, residual)
    return Fit(
        model=optimum,
        free=free,
        covariance=covariance,
        chi_squared=float(residual @ residual),
        evaluations=objective.evaluations,
        converged=bool(np.isfinite(step_in_sigmas) and step_in_sigmas < NEGLIGIBLE_STEP),
        message=str(result.message).strip(),
    )


def covariance_and_step(J: Array, residual: Array) -> tuple[Array, float]:
    """Return ``(J' J)^-1`` and the length of the remaining Gauss-Newton step in standard deviations.

    The step's length, ``|P_J r|`` with P_J the projection on the columns, is set against the residual's own size where that is large, so
    that a coarse model with many sigmas of misfit is not asked for more digits than it has. Where J or the residual is not finite
    there is no covariance, and the step is infinite.
    """
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    if not (np.all(np.isfinite(scale)) and np.isfinite(residual @ residual)):
        return np.full((len(scale), len(scale)), np.nan), np.inf
    # The triangular factor of [J r] has the same singular values and projections, at a quarter of the cost.
    factor = np.asarray(np.linalg.qr(np.column_stack([J / scale, residual]), mode="r"))
    U, s, Vt = np.linalg.svd(factor[: len(scale), :-1], full_matrices=False)
    if s.size == 0:
        return np.zeros((0, 0)), 0.0
    live = s > RANK_TOLERANCE * s[0]
    inverse = (Vt[live].T / s[live]) / scale[:, None]
    step = float(np.linalg.norm(U[:, live].T @ factor[: len(scale), -1]))
    rms = float(np.sqrt(residual @ residual / max(len(residual), 1)))
    return inverse @ inverse.T, step / max(1.0, rms)
