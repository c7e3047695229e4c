"""``scalar calibrate``: estimate robot, sensor and target together, with the standard error of each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from scalar.cli.corrected import corrected_description
from scalar.cli.group import cli
from scalar.cli.options import COMMANDED, EFFECTS_MODULE, OUTPUT, PATH, load_effects, lock_output, split_names
from scalar.cli.outputs import FORCE, is_report, json_of, refuse_foreign
from scalar.cli.terminal import say


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
    [...] may be left out, and ... repeated. JOINT counts from 1; ORDER is the number of periods in a turn; FROM is the
    number, in order of acquisition, of the first pose after a change; COLUMN and CLOCK are columns of poses.csv (time,
    temperature, order). Without a target, an effect is estimated wherever it can act. docs/effects.md says what each is.

    \b
    Examples:
      scalar calibrate my-cell -o out --report
      scalar calibrate my-cell -o out --effects joint_compliance,joint_scale:2
      scalar calibrate my-cell -o out --effects joint_harmonic:3:1,joint_coupling:6:5
      scalar calibrate my-cell -o out --effects-module my_effects.py --effects my_effect
      scalar calibrate later -o out2 --effects-from out/calibration.json
    """
    from scalar.cli.calibration_words import describe_calibration
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
    say(describe_calibration(result, data.sensor.T_flange_sensor))
    for line in note_on_names(source.nominal.name, data.robot.name) if source else ():
        say(line)
    for sentence in far_poses_in_words(result, data):
        say(f"  {sentence}")
    say(f"written: {output / 'calibration.json'}{', report.html' if with_report else ''}")
