"""Compare the residual of a model with the noise.

A model that lacks something leaves a larger residual than the noise explains. The excess counts as noise: it enlarges the standard errors and the
weight of priors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtrc  # what scipy.stats.chi2.sf calls, without its checks of arrays

from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS
from scalar.geometry.se3 import Array

# Chosen: the model lacks something if the ratio is larger than the first and the p-value smaller than the second.
_CLEARLY_LARGER, _NOT_BY_CHANCE = 1.15, 1e-3
_DOUBTFUL = 0.01  # chosen: with a p-value below this, it may lack something


@dataclass(frozen=True)
class Misfit:
    """How the residual compares with the noise.

    Attributes:
        ratio: Root mean square of the whitened residual over the value that the noise explains; about 1 for a complete model.
        p_value: Probability of a residual at least this large from noise alone; None where the noise is not known independently.
        inflation: Factor on the covariance, the squared ratio; 1 if the noise explains the residual.
    """

    ratio: float
    p_value: float | None
    inflation: float


def excess_factor(summary: Mapping[str, Any]) -> float:
    """Return the factor by which a misfit enlarges the standard errors of a calibration, at least 1; 1 if the summary states none.

    Args:
        summary: ``Calibration.summary``.
    """
    ratio = summary.get("misfit")
    return (
        1.0 if ratio is None else max(float(ratio), 1.0) * float(np.sqrt(summary.get("design_effect", 1.0)))
    )


def lacks_something(summary: Mapping[str, Any]) -> bool:
    """Return whether the residual of a calibration clearly exceeds what the noise explains.

    Args:
        summary: ``Calibration.summary``, with ``misfit`` and ``misfit_p_value``; one of these is None if the noise is not known.
    """
    ratio, p_value = summary.get("misfit"), summary.get("misfit_p_value")
    return ratio is not None and p_value is not None and ratio > _CLEARLY_LARGER and p_value < _NOT_BY_CHANCE


def may_lack_something(summary: Mapping[str, Any]) -> bool:
    """Return whether the residual of a calibration exceeds what the noise explains, although not clearly.

    The parameters absorb a part of what a model lacks: few poses may leave no more of a large effect than this.

    Args:
        summary: As for ``lacks_something``.
    """
    p_value = summary.get("misfit_p_value")
    return p_value is not None and p_value < _DOUBTFUL and not lacks_something(summary)


def misfit(
    residuals: Residuals, model: Model, free: Array, least_p_value: float = DEFAULTS.fit.misfit_p_value
) -> Misfit:
    """Return how far the residual exceeds the noise, without the scatter within scans.

    A scan's scatter about its own line carries no information on the model, and its many degrees of freedom would hide what the model lacks. Without
    it there remain two numbers for each scan (one for a contact, three for a tracked point). A parameter counts as a degree of freedom only by the
    share of it that the data determine; a prior determines the rest.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        free: ``(P,)`` bool.
        least_p_value: With a smaller p-value the model counts as incomplete.
    """
    measurement = residuals.measurement
    degrees_of_freedom = int(measurement.equations.sum()) - determined_by_data(residuals, model, free)
    if model.priors:
        chi_squared = residuals.normal_equations(model, free).squares
    else:
        chi_squared = float(np.sum(residuals.residual(model) ** 2))
    T = residuals.kinematics(model).T_base_sensor
    within, _ = measurement.scatter(T, model.target, residuals.point_effects(model))
    chi_squared -= float(within.sum())
    if residuals.known is not None:
        known = residuals.known
        degrees_of_freedom += 2 * int(np.isfinite(known.normal_std).sum()) + int(
            np.isfinite(known.distance_std).sum()
        )
    if degrees_of_freedom <= 0:
        return Misfit(1.0, None, 1.0)
    variance_ratio = chi_squared / degrees_of_freedom
    if measurement.sigma_known:
        p_value = float(chdtrc(degrees_of_freedom, max(chi_squared, 0.0)))
        return Misfit(
            float(np.sqrt(variance_ratio)), p_value, variance_ratio if p_value < least_p_value else 1.0
        )
    return Misfit(float(np.sqrt(variance_ratio)), None, variance_ratio)


def unexplained_shift(residuals: Residuals, model: Model, found: Misfit) -> float:
    """Return the root mean square shift [m] of the measured point that would explain why the residual exceeds the noise; zero if it does not.

    The shift is taken to be independent from pose to pose, with the same variance along each axis. A residual along one direction then shows a
    third of its mean square. If the arm does not repeat its poses, their scatter is part of the shift.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        found: As ``misfit`` returned it.
    """
    excess = max(found.ratio**2 - 1.0, 0.0) * int(residuals.measurement.equations.sum())
    if excess == 0.0:
        return 0.0
    return float(np.sqrt(excess / max(float(squares_for_a_shift(residuals, model).sum()), 1e-300)))


def squares_for_a_shift(residuals: Residuals, model: Model) -> Array:
    """Return the expected sum of squared whitened residuals ``(N,)`` of each pose for shifts of its measured point of 1 m root mean square.

    A shift is independent from pose to pose, and has the same variance along each axis.

    Args:
        residuals: Of the dataset.
        model: At which the directions of the measurements are computed.
    """
    common = residuals.measurement.common_error(residuals.kinematics(model).T_base_sensor, model.target)
    return np.sum(common**2, axis=(1, 2)) / 3.0


def determined_by_data(residuals: Residuals, model: Model, free: Array) -> float:
    """Return how many of the free coordinates the data determine rather than priors: MacKay's (1992) number of well-determined parameters.

    Args:
        residuals: Of the dataset.
        model: At its optimum.
        free: ``(P,)`` bool.
    """
    count = float(free.sum())
    if not model.priors:
        return count
    off, index, slope = model.prior_rows()
    variance, place = np.full(len(free), np.nan), np.cumsum(free) - 1
    if free[index].all() and len(set(index.tolist())) == len(index):
        normal = residuals.normal_equations(model, free).with_priors(place[index], off, slope)
        variances = normal.variances()
    else:
        variances = None
    if variances is None:
        residual, jacobian = residuals.linearise(model)
        variances = np.diag(covariance_and_step(jacobian[:, free], residual)[0])
    variance[free] = variances
    return count - float(variance[index] @ slope**2)
