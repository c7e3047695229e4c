"""Gaussian priors from the data sheet, for directions that the data determine hardly better than the data sheet does.

The estimate is the maximum a posteriori: with whitened rows r, the misfit ratio s and prior standard deviations t, it minimises
``|r|^2 / s^2 + |(x - mean) / t|^2`` over the parameters x (MacKay, Neural Computation 4, 1992). The misfit ratio is the ratio of the residual to the
noise, times the root of the design effect (``design_effect``). Directions that the data do not determine stay near the data sheet, and their standard
errors are then about the prior standard deviations. Directions that the data determine are hardly changed by the priors; if this holds for every
direction, no priors are used, and the estimate is that of least squares to the last digit.

A tool on the axis of the last joint needs no special case. If the tool is b metres off the axis and the axis is tilted about the tool, the tool
moves by b times the tilt when the wrist rotates. If this is small compared with the noise, the priors determine that tilt.

In a model with effects, a coordinate of the sensor's place that its prior decides is held near the prior's mean: in fits, the standard deviation of
its prior is multiplied by ``_HELD``. Else what the effects do not describe would move the sensor along it. Standard errors are computed with the full
standard deviation (``Model.released``), since holding a coordinate says nothing about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scalar.estimation.design_effect import design_effect
from scalar.estimation.gauss_newton import optimum_near
from scalar.estimation.initial_estimate import COARSE
from scalar.estimation.learned_prior_std import group_of, learned_prior_stds
from scalar.estimation.least_squares import covariance_and_step, fit
from scalar.estimation.misfit import misfit
from scalar.estimation.model import SENSOR_PARAMETERS, Model, ParameterPrior
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, EstimationSettings, IdentifiabilitySettings
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM

_CLEARLY = 3.0  # margin by which every direction is determined without doubt: further rounds change prior standard deviations by less
# Chosen: factor on the standard deviation of the prior on a coordinate of the sensor's place that the prior decides, while effects are fitted.
_HELD = 0.02
_PLACE_OF_SENSOR = SENSOR_PARAMETERS[:3]
_ROUNDS = 4  # in each, the model is fitted and the priors are weighted anew by the remaining residual; usually two suffice


def fit_near_data_sheet(
    residuals: Residuals,
    initial: Model,
    free: Array,
    settings: EstimationSettings = DEFAULTS,
    *,
    effects_follow: bool = False,
    near_optimum: bool = False,
) -> Model:
    """Return a coarse fit of all parameters, with priors unless the data determine every direction well without them.

    This is decided at the fit and not at the initial estimate, at which the tool may be nearer to an axis or farther from it. A direction is
    determined *well* if its standard error, misfit included, times ``settings.identifiability.prior_matters`` is less than its prior
    standard deviation.

    Args:
        residuals: The residuals of the dataset.
        initial: The initial estimate.
        free: ``(P,)`` bool, the parameters to fit.
        settings: Thresholds.
        effects_follow: Whether effects are added to the model afterwards. A large residual gives the priors much weight, and they would keep the
            geometry from adapting to the effect that causes it. No priors are used then if every direction would be well determined with the
            noise alone.
        near_optimum: Whether ``initial`` is already an optimum with other priors; Gauss-Newton steps from there save most of the time.
    """
    rules = settings.identifiability
    model = initial.with_priors(data_sheet_priors(initial, free, rules), 1.0)
    for _ in range(_ROUNDS):
        if near_optimum:
            model = optimum_near(residuals, model, free)
        else:
            model = fit(residuals, model, free, tolerance=COARSE).model
        if effects_follow and _determined(
            residuals, model, free, prior_std(model, rules), rules.prior_matters
        ):
            return model.with_priors((), 1.0).rebased()
        ratio = misfit_ratio(residuals, model, free, settings)
        reweighted = model.with_priors(model.priors, ratio)
        if initial.nominal.tolerance is None:
            reweighted = with_prior_stds(reweighted, learned_prior_stds(residuals, reweighted, free, rules))
        converged = _largest_change(model, reweighted) < rules.settled_weight
        model = reweighted
        if _determined_by(_CLEARLY, residuals, model, free, rules):
            return model.with_priors((), 1.0).rebased()
        if converged:
            break
    if _determined_by(1.0, residuals, model, free, rules):
        return model.with_priors((), 1.0).rebased()
    return _with_unseen_place_held(with_reasons(residuals, model, free, rules)).rebased()


def _determined_by(
    margin: float, residuals: Residuals, model: Model, free: Array, rules: IdentifiabilitySettings
) -> bool:
    """Return whether the data determine every direction well, by a margin on the ratio of prior standard deviation to standard error."""
    used = std_of_priors(model)
    scale = np.where(np.isfinite(used), used, prior_std(model, rules))
    return _determined(residuals, model, free, scale, margin * rules.prior_matters * model.misfit_ratio)


def _determined(residuals: Residuals, model: Model, free: Array, scale: Array, least: float) -> bool:
    """Return whether the data alone determine every direction well.

    They do if a change by one ``scale`` in any direction of the free parameters changes the whitened rows by a vector longer than ``least``.

    Args:
        residuals: The residuals of the dataset.
        model: Linearised here; its priors are not counted.
        free: ``(P,)`` bool.
        scale: ``(P,)`` [m or rad], a unit of each parameter.
        least: Length [standard deviations of the noise].
    """
    index = np.flatnonzero(free)
    longer = residuals.normal_equations(model, free).all_longer(scale[index], least)
    if longer is not None:
        return longer
    columns = residuals.linearise(model.with_priors((), 1.0))[1][:, index] * scale[index]
    if len(columns) < len(index):
        return False
    return float(np.linalg.svd(np.linalg.qr(columns, mode="r"), compute_uv=False)[-1]) > least


def data_sheet_priors(
    model: Model, free: Array, settings: IdentifiabilitySettings = DEFAULTS.identifiability
) -> tuple[ParameterPrior, ...]:
    """Return priors on every free length and angle of the robot and on the place of the sensor.

    Args:
        model: The initial estimate, or a later one with such priors. The prior means of the robot are its nominal values, those of the sensor its
            place in the initial estimate.
        free: ``(P,)`` bool; only free parameters get a prior.
        settings: Thresholds.
    """
    scale = prior_std(model, settings)
    initial = {prior.name: prior.mean for prior in model.priors}
    names, values, nominal = model.names, model.vector.tolist(), model.nominal.geometry.ravel().tolist()
    priors = []
    for i in np.flatnonzero(free[: model.blocks["target"].start]).tolist():
        name = names[i]
        if name.startswith("sensor_r"):  # the orientation of the sensor has no prior
            continue
        value = nominal[i] if i < len(nominal) else initial.get(name, float(values[i]))
        priors.append(ParameterPrior(name, float(value), float(scale[i]), ""))
    return tuple(priors)


def _with_unseen_place_held(model: Model) -> Model:
    """Return a model with effects whose sensor is held near its prior mean in the coordinates that the prior decides.

    A model without effects is returned as it is. What the effects do not describe moves the sensor along directions that the poses hardly determine,
    by as much as its prior allows. The residual hardly falls with it, and poses that turn the sensor otherwise are predicted worse by that length.

    Args:
        model: With priors; those that decide their parameter have a ``reason``.
    """
    if not model.effects:
        return model
    priors = [
        replace(prior, held=_HELD) if prior.reason and prior.name in _PLACE_OF_SENSOR else prior
        for prior in model.priors
    ]
    return model.with_priors(priors, model.misfit_ratio)


def with_prior_stds(model: Model, stds: Mapping[str, float]) -> Model:
    """Return the model with other standard deviations of the priors on the robot's parameters.

    Args:
        model: With priors.
        stds: The standard deviation of each group, ``{"length": m, "angle": rad, "zero": rad}``; priors of a group that is missing stay as they
            are.
    """
    priors = [
        ParameterPrior(prior.name, prior.mean, stds.get(group_of(prior.name), prior.std), prior.reason)
        for prior in model.priors
    ]
    return model.with_priors(priors, model.misfit_ratio)


def std_of_priors(model: Model) -> Array:
    """Return the standard deviation ``(P,)`` [m or rad] of the prior that the model has on each parameter, infinite where it has none."""
    found = np.full(len(model.names), np.inf)
    for prior in model.priors:
        found[model.names.index(prior.name)] = prior.std
    return found


def _largest_change(before: Model, after: Model) -> float:
    """Return the largest change of the logarithm of a prior's weight, the misfit ratio over the prior standard deviation."""
    log_weights_before, log_weights_after = (
        np.log([prior.std / model.misfit_ratio for prior in model.priors]) for model in (before, after)
    )
    return float(np.max(np.abs(log_weights_before - log_weights_after), initial=0.0))


def misfit_ratio(
    residuals: Residuals, model: Model, free: Array, settings: EstimationSettings = DEFAULTS
) -> float:
    """Return the factor on standard errors by which the data determine less than their noise alone would imply.

    The factor is the ratio of the residual to the noise, times the root of the design effect. A misfit is systematic, so the residuals of similar
    poses are correlated, and many such poses carry little more information than one. The factor is 1 if the noise explains the residual, or if too
    few degrees of freedom remain to decide.

    Args:
        residuals: Of the dataset.
        model: The fitted model.
        free: ``(P,)`` bool, the parameters that were fitted.
        settings: Thresholds.
    """
    degrees_of_freedom = float(residuals.measurement.equations.sum()) - float(free.sum())
    if degrees_of_freedom < settings.identifiability.enough_to_judge:
        return 1.0
    p_value = settings.fit.misfit_p_value
    ratio = float(np.sqrt(misfit(residuals, model, free, p_value).inflation))
    if ratio == 1.0:
        return ratio
    return ratio * float(np.sqrt(design_effect(residuals, model, free, ratio, p_value)))


def with_reasons(
    residuals: Residuals,
    model: Model,
    free: Array,
    settings: IdentifiabilitySettings = DEFAULTS.identifiability,
) -> Model:
    """Return the model with a sentence as the ``reason`` of each prior that decides its parameter; the other priors get an empty one.

    A prior decides a parameter if the standard error with prior and data exceeds ``settings.prior_decides`` times the prior standard deviation.

    Args:
        residuals: Of the dataset.
        model: Fitted, with priors.
        free: ``(P,)`` bool.
        settings: Thresholds.
    """
    residual, J = residuals.linearise(model)
    covariance, _ = covariance_and_step(J[:, free], residual)
    std = np.full(len(free), np.nan)
    std[free] = model.misfit_ratio * np.sqrt(np.diag(covariance))
    units = dict(zip(model.names, model.units, strict=True))
    reasoned = []
    for prior in model.priors:
        std_error = float(std[model.names.index(prior.name)])
        reason = ""
        if std_error > settings.prior_decides * prior.std:
            unit, word = (DEG, "deg") if units[prior.name] == "rad" else (MM, "mm")
            reason = (
                f"these poses determine it less closely than its prior standard deviation of {prior.std / unit:.2g} {word}; "
                f"with both, its standard error is {std_error / unit:.2g} {word}"
            )
        reasoned.append(replace(prior, reason=reason))
    return model.with_priors(reasoned, model.misfit_ratio)


def prior_std(model: Model, settings: IdentifiabilitySettings = DEFAULTS.identifiability) -> Array:
    """Return the prior standard deviation that the settings give each parameter, ``(P,)`` [m or rad].

    For the robot it is the maker's tolerance where one is stated. Parameters of the target are included, although they have no priors.
    """
    blocks = model.blocks
    stated = model.nominal.tolerance
    length, angle = (
        (settings.plausible_length, settings.plausible_angle)
        if stated is None
        else (stated.length, stated.angle)
    )
    scale = np.full(len(model.names), settings.plausible_target)
    lengths = np.array([unit == "m" for unit in model.units])
    scale[blocks["geometry"]] = np.where(lengths[blocks["geometry"]], length, angle)
    scale[blocks["sensor"]] = np.where(
        lengths[blocks["sensor"]], settings.plausible_sensor_place, settings.plausible_sensor_turn
    )
    return scale
