"""``scalar calibrate``: estimate robot, sensor and target together, with the standard error of each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.corrected import corrected_description
from scalar.cli.group import cli
from scalar.cli.options import COMMANDED, EFFECTS_MODULE, OUTPUT, PATH, load_effects, lock_output, split_names
from scalar.cli.outputs import FORCE, is_report, json_of, refuse_foreign
from scalar.cli.terminal import say
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.estimation.model import Model
    from scalar.estimation.result import Calibration

_NOTHING = 1e-6  # standard errors: a coefficient below it stands where its prior has it
_HIDDEN_SHOWN = 4  # such coefficients that are named


@cli.command()
@click.argument("dataset", type=PATH)
@OUTPUT
@click.option(
    "--effects",
    "effects",
    metavar="NAME,...",
    help="Estimate these effects as well; some need a target (a joint, a joint and an order, two joints): see the list above.",
)
@COMMANDED
@EFFECTS_MODULE
@click.option(
    "--effects-from",
    type=PATH,
    metavar="CALIBRATION",
    help="Take the arm's effects from another calibration and fix them.",
)
@click.option(
    "--hold",
    metavar="NAME,...",
    help="Fix these parameters at their nominal values, e.g. a_2,d_4 (joints of modified DH). "
    "With a standard-DH table also by its rows, as the summary names them: 'a 1,d 4'.",
)
@click.option(
    "--report",
    "with_report",
    is_flag=True,
    help="Write DIR/report.html too: the error over the workspace by the data sheet and as calibrated, and every parameter.",
)
@FORCE
def calibrate(
    dataset: Path,
    output: Path,
    effects: str | None,
    commanded: bool,
    effects_modules: Sequence[Path],
    effects_from: Path | None,
    hold: str | None,
    with_report: bool,
    force: bool,
) -> None:
    """Calibrate robot, sensor and target together.

    Writes DIR/calibration.json and prints a summary; with --report, writes DIR/report.html, which opens offline.

    \b
    Effects that --effects takes, by name, or by their title in the report ("joint 3: tilted axis"):
      joint_compliance[:JOINT...]    torque_compliance[:JOINT...]    payload_deflection[:JOINT...]
      joint_harmonic[:JOINT[:ORDER...]]    joint_ripple:JOINT:ORDER[...]    joint_scale[:JOINT]
      joint_coupling:JOINT:SOURCE    joint_backlash[:JOINT[:approach|moves|torque]]    joint_hysteresis[:JOINT]
      pose_lag[:JOINT[:step][:speed][:passing]]    axis_nonparallel[:JOINT]    base_compliance    thermal_drift[:COLUMN]
      restarted_warm_up[:CLOCK]    target_drift[:CLOCK]    target_drift:FROM
      sensor_slip:FROM    sensor_map    range_scale    range_offset    range_distortion
      plane_bow[:PLANE]    plane_moved:PLANE:FROM
    JOINT counts from 1, FROM is the order of the first pose after the change; without a target, an effect is
    estimated wherever it can act.

    \b
    Examples:
      scalar calibrate my-cell -o out --report
      scalar calibrate my-cell -o out --effects joint_compliance,joint_scale:2
      scalar calibrate my-cell -o out --effects joint_harmonic:3:1,joint_coupling:6:5
      scalar calibrate my-cell -o out --effects-module my_effects.py --effects my_effect
      scalar calibrate later -o out2 --effects-from out/calibration.json
    """
    from scalar.cli.progress import progress
    from scalar.data.dataset import read_dataset
    from scalar.effects.command_line import parse_effects
    from scalar.estimation.calibrate import calibrate
    from scalar.estimation.result import load_calibration
    from scalar.estimation.transfer import carried, note_on_names
    from scalar.geometry.standard_dh import from_row
    from scalar.report.calibration_residual import far_poses_in_words
    from scalar.report.output import write_calibration

    files = [(output / "calibration.json", json_of("calibration"))]
    files += [(output / "report.html", is_report)] if with_report else []
    refuse_foreign(files, force)
    lock_output(output)
    load_effects(effects_modules)
    data = read_dataset(dataset)
    held = [from_row(name, data.robot) for name in split_names(hold)]
    data = data.commanded() if commanded else data
    wanted = parse_effects(effects, data) if effects else ()
    source = load_calibration(effects_from).model if effects_from else None
    given = carried(source, data) if source else None
    with corrected_description(dataset, output), progress("calibrating"):
        result = calibrate(data, effects=wanted, fixed_effects=given.effects if given else (), fix=held)
    if given:
        result = replace(result, summary={**result.summary, "effects_from": given.to_mapping()})
    write_calibration(result, data, output, with_page=with_report)
    say(describe_calibration(result))
    for line in note_on_names(source.nominal.name, data.robot.name) if source else ():
        say(line)
    for sentence in far_poses_in_words(result, data):
        say(f"  {sentence}")
    say(f"written: {output / 'calibration.json'}{', report.html' if with_report else ''}")


def describe_calibration(calibration: Calibration) -> str:
    """Return a summary of a calibration: parameters, standard errors, and what the data do not determine."""
    from scalar.estimation import transfer
    from scalar.estimation.fixed_parameter import AS_ASKED
    from scalar.estimation.misfit import lacks_something, may_lack_something
    from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
    from scalar.geometry.standard_dh import in_rows
    from scalar.report.calibration_residual import residual_in_words
    from scalar.report.parameter_table import gauge_rows
    from scalar.report.scale_words import scanner_scale_in_words
    from scalar.report.unstated_noise import unstated_noise_in_words

    summary = calibration.summary
    model = calibration.model
    lines = [
        f"{model.robot.name}: {summary['poses']} poses, {summary['points']} points; "
        f"residual {calibration.residual_rms / MM:.4g} mm RMS",
    ]
    lines += [f"  check the set-up: {suspicion['sentence']}" for suspicion in summary.get("setup", [])]
    misfit = summary.get("misfit")
    if misfit is not None and summary.get("misfit_p_value") is not None:
        what = residual_in_words(summary)
        loud = "" if summary["points"] > summary["poses"] else ", or the noise is larger than stated"
        if lacks_something(summary):
            lines.append(
                f"  {what} is {misfit:.1f} times what the noise explains: "
                f"the model lacks something{loud}; try 'scalar diagnose'"
            )
        elif may_lack_something(summary):
            lines.append(
                f"  {what} is {misfit:.2f} times what the noise explains, which noise alone makes "
                f"with probability {summary['misfit_p_value']:.1g}: the model may lack something; 'scalar diagnose' looks for it"
            )
        else:
            lines.append(f"  the noise explains the residual (ratio {misfit:.2f})")
    elif unstated := unstated_noise_in_words(calibration):
        lines.append(f"  {unstated}")
    if scale := scanner_scale_in_words(calibration):
        lines.append(f"  {scale}")
    std = calibration.std
    standard = model.nominal.standard_dh

    def shown(text: str) -> str:
        return in_rows(text, model.nominal) if standard else text

    if standard:
        lines.append(
            "  parameters by the rows of the standard-DH table of dataset.yaml; calibration.json has them by joints of modified DH, "
            "where a_2 and alpha_2 are a and alpha of row 1; --hold takes either name"
        )
    lines.append("  parameter        nominal    calibrated        change     std")
    for kind in ("a", "alpha", "d", "theta"):
        for i in range(model.robot.n_joints):
            name = f"{kind}_{i + 1}"
            if name not in std:
                continue
            unit, text = (MM, "mm ") if kind in ("a", "d") else (DEG, "deg")
            nominal = model.nominal.geometry[("a", "alpha", "d", "theta").index(kind), i] / unit
            value = model.robot.geometry[("a", "alpha", "d", "theta").index(kind), i] / unit
            lines.append(
                f"    {shown(name):<9} {nominal:12.4f}  {value:12.4f}  {value - nominal:12.4f}  {std[name] / unit:8.4f} {text}"
            )
    t, r = model.sensor[:3] / MM, model.sensor[3:] / DEG
    rpy = rpy_from_rotation(model.T_flange_sensor[:3, :3]) / DEG
    lines.append(
        f"  sensor on flange: [{t[0]:.3f} {t[1]:.3f} {t[2]:.3f}] mm, rotation vector [{r[0]:.4f} {r[1]:.4f} {r[2]:.4f}] deg"
        f" (roll pitch yaw [{rpy[0]:.4f} {rpy[1]:.4f} {rpy[2]:.4f}] deg)"
    )
    for plane in calibration.to_mapping()["planes"]:
        n = plane["normal"]
        lines.append(
            f"  plane {plane['name']}: normal [{n[0]:.5f} {n[1]:.5f} {n[2]:.5f}], distance {plane['distance'] / MM:.3f} mm"
            + (f" +- {plane['distance_std_m'] / MM:.3f}" if plane["distance_std_m"] else "")
        )
    hidden: list[str] = []
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        for name, unit, value in zip(names, effect.coefficient_units, effect.coefficients, strict=True):
            if abs(value) < _NOTHING * std.get(name, 0.0):
                hidden.append(name)
                continue
            error = f" +- {std[name]:.2g}" if name in std else " (fixed)"
            sign = effect.sign_in_words
            shown_value, meaning = (abs(value), f": {sign}") if sign else (value, "")
            degrees = f" ({shown_value / DEG:.4g} deg)" if unit == "rad" else ""
            lines.append(f"  effect {name}: {shown_value:.4g}{error} {unit}{degrees}{meaning}")
        for joint, stiffness, error in effect.stiffness([std.get(name) for name in names]):
            known = (
                f"more than {error:.2g}"
                if isnan(stiffness)
                else f"{stiffness:.4g}" + (f" +- {error:.2g}" if error else "")
            )
            lines.append(f"    joint {joint}: stiffness {known} N m/rad")
    if hidden:
        more = f", and {len(hidden) - _HIDDEN_SHOWN} more" if len(hidden) > _HIDDEN_SHOWN else ""
        lines.append(f"  zero, because no pose shows them: {', '.join(hidden[:_HIDDEN_SHOWN])}{more}")
    lines += transfer.describe(summary.get("effects_from"))
    near = summary.get("kept_near_data_sheet") or {}
    if near:
        lines.append(
            f"  kept near the data sheet, because these poses hardly determine them: {', '.join(map(shown, near))}; {_assumed(calibration.model)}"
        )
    asked = [name for name, reason in calibration.fixed.items() if reason == AS_ASKED]
    if asked:
        rows = [f"{shown(name)} ({name})" if shown(name) != name else name for name in asked]
        lines.append(f"  fixed as asked ({len(asked)}): {', '.join(rows)}")
    fixed = gauge_rows(calibration) if standard else calibration.gauge
    if fixed:
        lines.append(f"  fixed, because the data do not determine them ({len(fixed)}):")
        lines += [f"    {entry['held']}: {entry['reason']}" for entry in fixed]
    return "\n".join(lines)


def _assumed(model: Model) -> str:
    """Return how far an arm is assumed to be from its data sheet by the priors of its calibration."""
    from scalar.estimation.learned_prior_std import group_of

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
