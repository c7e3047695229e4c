"""How the residual of a model compares with the noise: what the model lacks counts as noise in standard errors and against priors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS
from scalar.geometry.se3 import Array


@dataclass(frozen=True)
class Misfit:
    """How the residual compares with the noise.

    Attributes:
        ratio: Root of the residual's mean square over what the noise explains; about 1 for a complete model.
        p_value: Chance of a residual this large from noise alone; None where the noise is not known independently.
        inflation: Factor on the covariance.
    """

    ratio: float
    p_value: float | None
    inflation: float


def misfit(
    residuals: Residuals, model: Model, free: Array, least_p_value: float = DEFAULTS.fit.misfit_p_value
) -> Misfit:
    """Return how far the residual exceeds the noise, the scatter within scans set apart.

    A scan's scatter about its own line carries no information on the model, and has many degrees of freedom: left in, it would hide
    what the model lacks. What remains are two numbers a scan (one a contact, three a tracked point). A parameter that a prior determines
    takes none of them: each takes the share of itself that the data determine.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        free: ``(P,)`` bool.
        least_p_value: A residual less likely than this under the noise says that the model lacks something.
    """
    measurement = residuals.measurement
    squared = float(np.sum(residuals.residual(model) ** 2)) - float(np.sum(_pulls(model) ** 2))
    T = residuals.kinematics(model).T_base_sensor
    within, _ = measurement.scatter(T, model.target, residuals.point_effects(model))
    squared -= float(within.sum())
    freedom = int(measurement.equations.sum()) - determined_by_data(residuals, model, free)
    if residuals.known is not None:
        known = residuals.known
        freedom += 2 * int(np.isfinite(known.normal_std).sum()) + int(np.isfinite(known.distance_std).sum())
    if freedom <= 0:
        return Misfit(1.0, None, 1.0)
    ratio = squared / freedom
    if measurement.sigma_known:
        p_value = float(chi2.sf(squared, freedom))
        return Misfit(float(np.sqrt(ratio)), p_value, ratio if p_value < least_p_value else 1.0)
    return Misfit(float(np.sqrt(ratio)), None, ratio)


def determined_by_data(residuals: Residuals, model: Model, free: Array) -> float:
    """Return how many of the free coordinates the data determine rather than priors: the trace of MacKay (1992), all where there is no prior.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        free: ``(P,)`` bool.
    """
    count = float(free.sum())
    if not model.priors:
        return count
    residual, jacobian = residuals.linearise(model)
    covariance, _ = covariance_and_step(jacobian[:, free], residual)
    variance = np.full(len(free), np.nan)
    variance[free] = np.diag(covariance)
    for prior in model.priors:
        count -= float(variance[model.names.index(prior.name)]) * (model.misfit_ratio / prior.std) ** 2
    return count


def _pulls(model: Model) -> Array:
    """Return the rows of the priors on parameters."""
    at = dict(zip(model.names, model.vector, strict=True))
    rows = [(at[prior.name] - prior.mean) * model.misfit_ratio / prior.std for prior in model.priors]
    return np.array(rows, dtype=float)
