"""Gaussian priors from the data sheet, for parameters that the data determine no better than it does."""

from __future__ import annotations

import numpy as np

from scalar.estimation.model import Model, ParameterPrior
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, IdentifiabilitySettings
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM


def data_sheet_priors(
    residuals: Residuals,
    model: Model,
    free: Array,
    found: Model,
    settings: IdentifiabilitySettings = DEFAULTS.identifiability,
) -> tuple[ParameterPrior, ...]:
    """Return priors that keep robot and sensor near the data sheet, if the data determine some direction no better than it does.

    In units of the prior standard deviations s, with columns ``J s``, a direction whose standard error exceeds 1 is weak. The noise
    is estimated from the residual that neither one step of the model nor a fit removes, so that what the model lacks counts as noise.
    Where no direction is weak there is no prior. Where one is, every length and angle gets its prior, which changes little in what
    the data determine well.

    Args:
        residuals: Of the dataset.
        model: The initial estimate.
        free: ``(P,)`` bool.
        found: Where a fit from there ended, without priors: the initial estimate may be too far off for one step.
        settings: Thresholds.
    """
    residual, J = residuals.linearise(model)
    scatter, lines = _apart_from_scatter(residuals, model)
    left = residuals.residual(found)
    after = float(left @ left) - _apart_from_scatter(residuals, found)[0]
    index = np.flatnonzero(free)
    k = len(index)
    scale = prior_std(model, settings)
    factor = np.asarray(np.linalg.qr(np.column_stack([J[:, index] * scale[index], residual]), mode="r"))
    freedom = lines - k
    excess = min(float(np.sum(factor[k:, -1] ** 2)) - scatter, after)
    noise = (
        max(float(np.sqrt(excess / freedom)), 1.0)
        if freedom >= settings.enough_to_judge and excess > 0
        else 1.0
    )
    _, s, Vt = np.linalg.svd(factor[:k, :k])
    if s[-1] >= noise:
        return ()
    weak = s < noise
    spread = noise * np.sqrt(np.sum((Vt[weak].T / np.maximum(s[weak], 1e-12)) ** 2, axis=1)) * scale[index]
    kept = []
    for i, std in zip(index, spread, strict=True):
        name, is_angle = model.names[i], model.units[i] == "rad"
        if i >= model.blocks["target"].start or name.startswith("sensor_r"):
            continue
        value = model.nominal.geometry.ravel()[i] if i < model.blocks["geometry"].stop else model.vector[i]
        reason = ""
        if std > scale[i] / 2:
            size = f"{std / DEG:.2g} deg" if is_angle else f"{std / MM:.2g} mm"
            reason = (
                f"these poses alone determine it only to about {size}, no better than the data sheet does"
            )
        kept.append(ParameterPrior(name, float(value), float(scale[i] / noise), reason))
    return tuple(kept)


def _apart_from_scatter(residuals: Residuals, model: Model) -> tuple[float, int]:
    """Return the squared scatter of points about their own scans' lines, which no model explains, and the number of other rows."""
    measurement = residuals.measurement
    within, _ = measurement.scatter(residuals.kinematics(model).T_base_sensor, model.target)
    return float(within.sum()), int(measurement.equations.sum())


def prior_std(model: Model, settings: IdentifiabilitySettings = DEFAULTS.identifiability) -> Array:
    """Return how far each coordinate may be from where it is said to be, ``(P,)`` [m or rad]."""
    blocks = model.blocks
    scale = np.full(len(model.names), settings.plausible_target)
    lengths = np.array([unit == "m" for unit in model.units])
    scale[blocks["geometry"]] = np.where(
        lengths[blocks["geometry"]], settings.plausible_length, settings.plausible_angle
    )
    scale[blocks["sensor"]] = np.where(
        lengths[blocks["sensor"]], settings.plausible_sensor_place, settings.plausible_sensor_turn
    )
    return scale
