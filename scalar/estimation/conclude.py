"""Turn a converged fit into a calibration: reporting coordinates, standard errors, and which parameters are fixed and why."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.formats import FEW_PLANES, IMPORTED
from scalar.effects import registry
from scalar.errors import Undetermined
from scalar.estimation.design_effect import design_effect, standstills
from scalar.estimation.fixed_parameter import AS_ASKED, NO_LENGTH_KNOWN
from scalar.estimation.least_squares import Decomposed, Fit
from scalar.estimation.measured_ranges import MEASURED_COLUMNS, MEASURED_RANGES, ranges_of_columns
from scalar.estimation.misfit import Misfit, misfit, unexplained_shift
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared
from scalar.estimation.ran_away import ran_away
from scalar.estimation.random_poses import ranges_of_joints
from scalar.estimation.reporting import reporting, sensor_mapping
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.estimation.scanner_scale import SCANNER_SCALE_SHIFT, unchecked_scale
from scalar.estimation.settings import DEFAULTS, FitSettings
from scalar.estimation.setup.arm.lengths import LENGTH_UNIT
from scalar.estimation.setup.plausibility import implausible
from scalar.estimation.setup.sensor.stretched_axis import stretched_axis_in_words
from scalar.estimation.setup.sessions.undetermined_session import undetermined_session
from scalar.estimation.setup.suspicion import Suspicion, WrongSetup
from scalar.estimation.setup.tables.copies import reads_again
from scalar.estimation.suspected_setup import with_suspicions
from scalar.estimation.unseen_directions import UNSEEN_DIRECTIONS, unseen_directions
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import as_stated
from scalar.sensors.pose_noise import ROTATION_NOISE


def conclude(
    dataset: Dataset,
    prepared: Prepared,
    found: Fit,
    residuals: Residuals,
    settings: FitSettings = DEFAULTS.fit,
) -> Calibration:
    """Return the calibration of a converged fit: reporting coordinates, standard errors, which parameters are fixed and why.

    The covariance follows from the noise. If the residual is larger than the noise explains, it is multiplied by the misfit's inflation and by the
    design effect: what a model lacks makes the residuals of similar poses correlated, so that they determine less than their number says.

    Args:
        dataset: What was measured.
        prepared: The same dataset, prepared for the fit.
        found: The converged fit.
        residuals: Whitened at the optimum.
        settings: Thresholds.

    Raises:
        Undetermined: The data do not distinguish all free parameters, or a length or an angle is implausibly far from its nominal value.
    """
    model = reporting(found.model.released(), prepared.guess)
    of_noise = _covariance_of_noise(dataset, model, residuals, found.free)
    lack = misfit(residuals, model, found.free, settings.misfit_p_value)
    design_factor = _design_effect(model, residuals, found.free, lack, settings)
    covariance = of_noise * (lack.inflation * design_factor)
    _check_plausible(model, settings)
    rms, std = residuals.rms(model), _std(covariance, found.free)
    suspicions = [*_suspicions(dataset, prepared, model, residuals, std, lack, rms)]
    if lack.inflation != 1.0 or lack.p_value is None:
        suspicions += stretched_axis_in_words(dataset, model, found.free)
    if units := tuple(suspicion for suspicion in suspicions if suspicion.what == LENGTH_UNIT):
        raise WrongSetup(units)
    summary = _summary(dataset, prepared, found, residuals, model, of_noise, lack, design_factor)
    free = tuple(name for name, is_free in zip(model.names, found.free, strict=True) if is_free)
    if unseen := unseen_directions(residuals, model, free, covariance):
        summary[UNSEEN_DIRECTIONS] = unseen
    calibration = Calibration(
        model=model,
        sensor=sensor_mapping(dataset),
        free=free,
        covariance=covariance,
        fixed=_fixed(model, prepared, found.free),
        gauge=tuple(
            {"held": h.name, "reason": h.reason, "moves_with": list(h.moves_with), "cause": h.cause}
            for h in prepared.identifiability.fixed
        ),
        residual_rms=rms,
        summary=summary,
        noise=tuple(component.to_mapping() for component in residuals.measurement.listed_noise),
    )
    return with_suspicions(calibration, suspicions)


def _covariance_of_noise(dataset: Dataset, model: Model, residuals: Residuals, free: Array) -> Array:
    """Return the covariance ``(f, f)`` of the f free parameters that follows from the noise.

    Raises:
        Undetermined: The data do not distinguish all free parameters.
    """
    if not model.priors and residuals.plane_problem(model) is not None:
        found = residuals.normal_equations(model, free).covariance_and_step()
        if found is not None:  # so well conditioned that the rank is beyond doubt
            return found[0]
    residual, jacobian = residuals.linearise(model)
    decomposed = Decomposed.of(jacobian[:, free], residual)
    assert decomposed is not None  # the fit has converged, so all numbers are finite
    _check_rank(dataset, model, decomposed, free)
    return decomposed.covariance


def _design_effect(
    model: Model, residuals: Residuals, free: Array, lack: Misfit, settings: FitSettings
) -> float:
    """Return the design effect on the covariance: 1 if the noise explains the residual, unless readings of one standstill share an error.

    Readings of an arm that stands still share the error that its repeatability leaves. It need not make the residual larger than the stated noise
    does, and yet several readings then determine little more than one.
    """
    ratio, found = float(np.sqrt(lack.inflation)), [1.0]
    standstill = standstills(residuals.poses.q, residuals.poses.order)
    if reads_again(standstill):
        found.append(design_effect(residuals, model, free, ratio, settings.misfit_p_value, standstill))
    if lack.inflation != 1.0:
        found.append(design_effect(residuals, model, free, ratio, settings.misfit_p_value))
    return max(found)


def _std(covariance: Array, free: Array) -> Array:
    """Return the standard error of each parameter ``(p,)`` in its own unit, NaN of a fixed one.

    Args:
        covariance: ``(f, f)``, of the free parameters.
        free: ``(p,)`` bool, which parameters are free.
    """
    std = np.full(len(free), np.nan)
    std[free] = np.sqrt(np.diag(covariance))
    return std


def _suspicions(
    dataset: Dataset,
    prepared: Prepared,
    model: Model,
    residuals: Residuals,
    std: Array,
    lack: Misfit,
    rms: float,
) -> Sequence[Suspicion]:
    """Return what the calibrated parameters make doubtful in the set-up; ``std`` is what ``_std`` returns, ``rms`` that of the residual [m]."""
    measurement = residuals.measurement
    to_stated = measurement.ratio_to_stated
    rotation_noise = (n.value for n in measurement.estimated_noise if n.name == ROTATION_NOISE)
    no_length = (h.name for h in prepared.identifiability.fixed if h.reason == NO_LENGTH_KNOWN)
    return implausible(
        dataset,
        model,
        std,
        guess=prepared.guess,
        rotation_observed=measurement.observes_orientation,
        residual=rms,
        misfit_ratio=None if to_stated is None else lack.ratio * to_stated,
        rotation_noise=max(rotation_noise, default=0.0),
        fixed_length=next(no_length, None),
    )


def _fixed(model: Model, prepared: Prepared, free: Array) -> dict[str, str]:
    """Return why each fixed parameter is fixed, by its name: first those that the data do not determine, then the others."""
    fixed = {h.name: h.reason for h in prepared.identifiability.fixed}
    freed_by = cache(registry.freed_by)
    for name, is_free in zip(model.names, free, strict=True):
        if not is_free and name not in fixed:
            is_effect = "." in name and name not in prepared.initial.model.names
            fixed[name] = _why_fixed(freed_by(name.split("_")[0]), is_effect)
    return fixed


def _why_fixed(freed_by: str | None, is_effect: bool) -> str:
    """Return why a parameter is fixed that the data might determine.

    Args:
        freed_by: Name of the effect that frees parameters of its kind, or None.
        is_effect: Whether it is a coefficient of an effect.
    """
    if freed_by is not None:
        return f"fixed at its nominal value; the effect {freed_by} frees it"
    return (
        "fixed as asked, or its residual is a combination of those of other parameters"
        if is_effect
        else AS_ASKED
    )


def _summary(
    dataset: Dataset,
    prepared: Prepared,
    found: Fit,
    residuals: Residuals,
    model: Model,
    covariance: Array,
    lack: Misfit,
    design_factor: float,
) -> dict[str, Any]:
    """Return the summary of a calibration, with an empty list of suspicions.

    Args:
        dataset: What was measured.
        prepared: The same dataset, prepared for the fit.
        found: The converged fit.
        residuals: Whitened at the optimum.
        model: The fitted model in reporting coordinates.
        covariance: ``(f, f)``, of the f free parameters, as it follows from the noise.
        lack: How the residual compares with the noise.
        design_factor: The design effect.
    """
    summary: dict[str, Any] = {
        "poses": dataset.n_poses,
        "points": len(dataset.points) if len(dataset.points) else dataset.n_poses,
        MEASURED_RANGES: ranges_of_joints(dataset.q).tolist(),
        MEASURED_COLUMNS: ranges_of_columns(dataset, model.effects),
        "sigma_m": residuals.measurement.sigma,
        "sigma_stated": residuals.measurement.sigma_stated,
        "misfit": lack.ratio,
        "misfit_p_value": lack.p_value,
        "design_effect": design_factor,
        "misfit_shift_m": unexplained_shift(residuals, model, lack),
        "started_from": prepared.initial.origin,
        "start_rms_m": prepared.initial.rms,
        "evaluations": found.evaluations,
        "chi_squared": found.chi_squared,
        "kept_near_data_sheet": {a.name: a.reason for a in model.priors if a.reason},
        "singular_values": [float(s) for s in prepared.identifiability.singular_values],
    }
    if (shift := unchecked_scale(residuals, model, found.free, covariance)) is not None:
        summary[SCANNER_SCALE_SHIFT] = shift
    if dataset.imported:
        summary[IMPORTED] = dict(dataset.imported)
    if dataset.few_planes:
        summary[FEW_PLANES] = True
    return summary | {"setup": []}


def _check_rank(dataset: Dataset, model: Model, decomposed: Decomposed, free: Array) -> None:
    """Refuse to state standard errors if the data do not determine the free parameters.

    Raises:
        Undetermined: Naming the parameters that cannot be distinguished, or the session whose poses are too few or too much alike.
    """
    if decomposed.full_rank:
        return
    names = np.array(model.names)[free]
    largest = names[np.argsort(-np.abs(decomposed.weakest))[:4]]
    if sentence := undetermined_session(dataset, largest.tolist()):
        raise Undetermined([sentence])
    raise Undetermined(
        [
            f"the data do not distinguish {as_stated(', '.join(largest), model.nominal)}: measure more poses that "
            "differ in all joints, or fix one of them (--hold)"
        ]
    )


def _check_plausible(model: Model, settings: FitSettings) -> None:
    """Refuse a robot that no workshop could have built from its data sheet.

    Raises:
        Undetermined: A length or an angle ran away from its nominal value.
    """
    reasons = [
        f"{as_stated(name, model.nominal)} ran {size:.0f} {unit} away from its nominal value, and at most {bound:.0f} {unit} are plausible: "
        "check it in robot.joints of dataset.yaml, and whether this is the robot; if both are right, the poses hardly determine it"
        for name, size, bound, unit in ran_away(model, settings)
    ]
    if reasons:
        raise Undetermined(reasons)
