"""The summary of a calibration that ``scalar calibrate`` prints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isnan

import numpy as np

from scalar.effects import Effect
from scalar.estimation import transfer
from scalar.estimation.fixed_parameter import AS_ASKED
from scalar.estimation.learned_prior_std import group_of
from scalar.estimation.misfit import lacks_something, may_lack_something
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import in_rows
from scalar.report.calibration_residual import residual_in_words
from scalar.report.parameter_table import gauge_rows
from scalar.report.scale_words import scanner_scale_in_words
from scalar.report.unseen_directions_words import unseen_directions_in_words
from scalar.report.unstated_noise import unstated_noise_in_words
from scalar.units import DEG, MM

_NOTHING = 1e-6  # standard errors: a coefficient below it stands where its prior has it
_HIDDEN_SHOWN = 4  # such coefficients that are named
_DH_KINDS = GEOMETRY[:4]  # without beta, which belongs to an effect


def describe_calibration(calibration: Calibration, T_stated: Array | None = None) -> str:
    """Return a summary of a calibration: parameters, standard errors, and what the data do not determine.

    Args:
        calibration: The calibration.
        T_stated: ``(4, 4)``, the sensor's pose on the flange that the dataset states; None if it states none.
    """
    return "\n".join(
        [
            *_lines_on_fit(calibration),
            *_lines_on_geometry(calibration),
            _line_on_sensor(calibration.model, T_stated),
            *_lines_on_planes(calibration),
            *_lines_on_effects(calibration),
            *transfer.describe(calibration.summary.get("effects_from")),
            *_lines_on_priors(calibration),
            *_lines_on_fixed(calibration),
        ]
    )


def _lines_on_fit(calibration: Calibration) -> Iterator[str]:
    """Yield how large the residual is, what of the set-up is doubtful, and whether noise explains the residual."""
    summary = calibration.summary
    yield (
        f"{calibration.model.robot.name}: {summary['poses']} poses, {summary['points']} points; "
        f"residual {calibration.residual_rms / MM:.4g} mm RMS"
    )
    for suspicion in summary.get("setup", []):
        yield f"  check the set-up: {suspicion['sentence']}"
    if summary.get("misfit") is not None and summary.get("misfit_p_value") is not None:
        yield _line_on_misfit(calibration)
    elif unstated := unstated_noise_in_words(calibration):
        yield f"  {unstated}"
    yield from lines_on_scanner_and_planes(calibration)


def lines_on_scanner_and_planes(calibration: Calibration) -> Iterator[str]:
    """Yield that the data do not show the scale of the scanner, and which directions the planes do not show; nothing if the data show both."""
    for said in (scanner_scale_in_words(calibration), unseen_directions_in_words(calibration)):
        if said:
            yield f"  {said}"


def _line_on_misfit(calibration: Calibration) -> str:
    """Return how the residual compares with the stated noise."""
    summary = calibration.summary
    what, misfit = residual_in_words(summary), summary["misfit"]
    loud = "" if summary["points"] > summary["poses"] else ", or the noise is larger than stated"
    if lacks_something(summary):
        return (
            f"  {what} is {misfit:.1f} times what the noise explains: "
            f"the model lacks something{loud}; try 'scalar diagnose'"
        )
    if may_lack_something(summary):
        return (
            f"  {what} is {misfit:.2f} times what the noise explains, which noise alone makes "
            f"with probability {summary['misfit_p_value']:.1g}: the model may lack something; 'scalar diagnose' looks for it"
        )
    return f"  the noise explains the residual (ratio {misfit:.2f})"


def _lines_on_geometry(calibration: Calibration) -> Iterator[str]:
    """Yield a table of the free parameters of the joints."""
    model, std = calibration.model, calibration.std
    if model.nominal.standard_dh:
        yield (
            "  parameters by the rows of the standard-DH table of dataset.yaml; calibration.json has them by joints of modified DH, "
            "where a_2 and alpha_2 are a and alpha of row 1; --hold takes either name"
        )
    yield "  parameter        nominal    calibrated        change     std"
    for row, kind in enumerate(_DH_KINDS):
        unit, text = (MM, "mm ") if kind in ("a", "d") else (DEG, "deg")
        for i in range(model.robot.n_joints):
            name = f"{kind}_{i + 1}"
            if name not in std:
                continue
            nominal, value = model.nominal.geometry[row, i] / unit, model.robot.geometry[row, i] / unit
            yield (
                f"    {_as_shown(name, model):<9} {nominal:12.4f}  {value:12.4f}  {value - nominal:12.4f}  {std[name] / unit:8.4f} {text}"
            )


def _line_on_sensor(model: Model, T_stated: Array | None) -> str:
    """Return the pose of the sensor on the flange, and how far it is from the stated one."""
    t, r = model.sensor[:3] / MM, model.sensor[3:] / DEG
    rpy = rpy_from_rotation(model.T_flange_sensor[:3, :3]) / DEG
    far = None if T_stated is None else float(np.linalg.norm(t - T_stated[:3, 3] / MM))
    from_stated = "" if far is None else f"; {far:.1f} mm from where nominal_pose has it"
    return (
        f"  sensor on flange: [{t[0]:.3f} {t[1]:.3f} {t[2]:.3f}] mm, rotation vector [{r[0]:.4f} {r[1]:.4f} {r[2]:.4f}] deg"
        f" (roll pitch yaw [{rpy[0]:.4f} {rpy[1]:.4f} {rpy[2]:.4f}] deg){from_stated}"
    )


def _lines_on_planes(calibration: Calibration) -> Iterator[str]:
    """Yield where each target plane is."""
    for plane in calibration.to_mapping()["planes"]:
        n = plane["normal"]
        std = f" +- {plane['distance_std_m'] / MM:.3f}" if plane["distance_std_m"] else ""
        yield (
            f"  plane {plane['name']}: normal [{n[0]:.5f} {n[1]:.5f} {n[2]:.5f}], distance {plane['distance'] / MM:.3f} mm{std}"
        )


def _lines_on_effects(calibration: Calibration) -> Iterator[str]:
    """Yield the coefficients of each effect, and at the end the names of those that no pose shows."""
    model, std = calibration.model, calibration.std
    hidden: list[str] = []
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        for name, unit, value in zip(names, effect.coefficient_units, effect.coefficients, strict=True):
            if abs(value) < _NOTHING * std.get(name, 0.0):
                hidden.append(name)
                continue
            error = f" +- {std[name]:.2g}" if name in std else " (fixed)"
            sign = effect.sign_in_words
            shown, meaning = (abs(value), f": {sign}") if sign else (value, "")
            degrees = f" ({shown / DEG:.4g} deg)" if unit == "rad" else ""
            yield f"  effect {name}: {shown:.4g}{error} {unit}{degrees}{meaning}"
        yield from _lines_on_stiffness(effect, [std.get(name) for name in names])
    if hidden:
        more = f", and {len(hidden) - _HIDDEN_SHOWN} more" if len(hidden) > _HIDDEN_SHOWN else ""
        yield f"  zero, because no pose shows them: {', '.join(hidden[:_HIDDEN_SHOWN])}{more}"


def _lines_on_stiffness(effect: Effect, std: Sequence[float | None]) -> Iterator[str]:
    """Yield the stiffness of each joint that an effect states, from the standard errors of its coefficients."""
    for joint, stiffness, error in effect.stiffness(std):
        if isnan(stiffness):
            known = f"more than {error:.2g}"
        else:
            known = f"{stiffness:.4g}" + (f" +- {error:.2g}" if error else "")
        yield f"    joint {joint}: stiffness {known} N m/rad"


def _lines_on_priors(calibration: Calibration) -> Iterator[str]:
    """Yield which parameters the priors keep near the data sheet."""
    model, near = calibration.model, calibration.summary.get("kept_near_data_sheet")
    if near:
        names = ", ".join(_as_shown(name, model) for name in near)
        yield f"  kept near the data sheet, because these poses hardly determine them: {names}; {_assumed(model)}"


def _lines_on_fixed(calibration: Calibration) -> Iterator[str]:
    """Yield which parameters are fixed because the user asked for it, and which because the data do not determine them."""
    model = calibration.model
    asked = [name for name, reason in calibration.fixed.items() if reason == AS_ASKED]
    if asked:
        shown = [(name, _as_shown(name, model)) for name in asked]
        rows = [f"{row} ({name})" if row != name else name for name, row in shown]
        yield f"  fixed as asked ({len(asked)}): {', '.join(rows)}"
    fixed = gauge_rows(calibration) if model.nominal.standard_dh else calibration.gauge
    if fixed:
        yield f"  fixed, because the data do not determine them ({len(fixed)}):"
        for entry in fixed:
            yield f"    {entry['held']}: {entry['reason']}"


def _as_shown(name: str, model: Model) -> str:
    """Return the name of a parameter as the table of the user's dataset has it: by rows of standard DH where that is how it is written."""
    return in_rows(name, model.nominal) if model.nominal.standard_dh else name


def _assumed(model: Model) -> str:
    """Return how far an arm is assumed to be from its data sheet by the priors of its calibration."""
    stds = {group_of(prior.name): prior.std for prior in model.priors}
    words = {"length": "lengths", "angle": "angles", "zero": "joint zeros"}
    sizes = [
        f"{word} {stds[group] / MM:.2g} mm" if group == "length" else f"{word} {stds[group] / DEG:.2g} deg"
        for group, word in words.items()
        if group in stds
    ]
    source = (
        "as robot.tolerance states"
        if model.nominal.tolerance is not None
        else "estimated from this arm; if its maker states a tolerance, state it as robot.tolerance"
    )
    return f"assumed standard deviations: {', '.join(sizes)} ({source})"
