"""The same fit through lmfit, for its report: values, standard errors, correlations, fit statistics, under the parameters' names.

lmfit calls MINPACK with the same residual, Jacobian and tolerances as ``scalar.estimation.least_squares``, so both end at the same optimum.
lmfit itself takes many times as long as the fit, so a calibration does not use it.
"""

from __future__ import annotations

from typing import Any

import lmfit
from lmfit.minimizer import MinimizerResult

from scalar.estimation.least_squares import FIRST_STEP, MAX_EVALUATIONS, TOLERANCE, Fit, Objective
from scalar.estimation.lmfit_parameters import from_lmfit, to_lmfit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array


def fit_with_lmfit(
    residuals: Residuals, model: Model, free: Array, *, tolerance: float = TOLERANCE
) -> tuple[Fit, MinimizerResult]:
    """Return the least-squares optimum over the free coordinates of a model, and lmfit's own result: ``lmfit.fit_report`` prints it.

    lmfit states a covariance whatever the conditioning; that of the fit leaves out directions that the data do not observe.

    Args:
        residuals: Of the dataset.
        model: Initial values; fixed coordinates keep them.
        free: ``(P,)`` bool; at least one is free.
        tolerance: Relative, on cost and coordinates.
    """
    objective = Objective(residuals, model, free)
    names = [model.names[i] for i in objective.free]
    minimiser = lmfit.Minimizer(
        lambda parameters: objective.residual(from_lmfit(parameters)),
        to_lmfit(names, objective.start[objective.free]),
        scale_covar=False,
        nan_policy="propagate",
        max_nfev=MAX_EVALUATIONS,
    )
    result: Any = minimiser.leastsq(
        Dfun=lambda parameters: objective.jacobian(from_lmfit(parameters)).copy(),
        col_deriv=0,
        ftol=tolerance,
        xtol=tolerance,
        gtol=0.0,
        factor=FIRST_STEP,
    )
    return objective.ended(from_lmfit(result.params), free, str(result.message).strip()), result
