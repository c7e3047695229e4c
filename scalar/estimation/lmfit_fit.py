"""The same fit through lmfit, for its report: values, standard errors, correlations, fit statistics, under the parameters' names.

lmfit calls MINPACK with the same residual, Jacobian and tolerances as ``scalar.estimation.least_squares``, so both end at the same optimum.
lmfit itself takes many times as long as the fit, so a calibration does not use it.
"""

from __future__ import annotations

from typing import Any

import lmfit
import numpy as np
from lmfit.minimizer import MinimizerResult

from scalar.estimation.least_squares import FIRST_STEP, MAX_EVALUATIONS, TOLERANCE, Fit, Objective
from scalar.estimation.lmfit_parameters import from_lmfit, to_lmfit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array


class _Minimizer(lmfit.Minimizer):
    """lmfit's Minimizer, which computes all correlations at once: one by one they take as long as a third of its steps.

    The method is not part of lmfit's documented interface. If another version has it no more, that version's own way is taken, with the same result.
    """

    def _calculate_uncertainties_correlations(self) -> None:
        """Set standard errors and correlations of all parameters at once; lmfit takes one pair of parameters after another."""
        result: Any = self.result
        std = np.sqrt(np.diag(result.covar))
        if self.scale_covar or not np.all(std > 0):
            super()._calculate_uncertainties_correlations()
            return
        rows = (result.covar / (std[:, None] * std)).tolist()
        for name, error, row in zip(result.var_names, std.tolist(), rows, strict=True):
            correlations = dict(zip(result.var_names, row, strict=True))
            del correlations[name]
            result.params[name].stderr, result.params[name].correl = error, correlations
        result.errorbars, result.uvars = True, result.params.create_uvars(covar=result.covar)


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
    minimiser = _Minimizer(
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
