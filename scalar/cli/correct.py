"""``scalar correct``: joint angles that take the real arm to the wanted frames."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.convention import MAPPING, convention_of, lines_on_convention
from scalar.cli.correct_words import (
    faults_of,
    line_on_wanted_frames,
    lines_on_left_out,
    lines_on_tool,
    takes_large_turns,
    warnings_on_written,
)
from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, UNITS, load_effects
from scalar.cli.outputs import FORCE, refuse_foreign, table_with
from scalar.cli.terminal import say, say_written
from scalar.data.formats import IMPORTED
from scalar.errors import InvalidInput

if TYPE_CHECKING:
    from scalar.cli.corrected_targets import CorrectedTargets
    from scalar.cli.targets import Targets
    from scalar.estimation.result import Calibration

_CHOSEN = (
    "  each posture was chosen near that of the row before, and in the first row and after a large move within the measured ranges of the joints, if "
    "one lies there; to choose another one, give its joint angles in columns q1..qn, next to the frames"
)


@cli.command()
@click.argument("calibration", type=PATH)
@click.argument("targets", type=PATH)
@click.option("-o", "--output", type=PATH, required=True, help="CSV file to write.")
@UNITS
@MAPPING
@click.option(
    "--leave-out",
    is_flag=True,
    help="Leave out poses that cannot be corrected, instead of marking them.",
)
@FORCE
@EFFECTS_MODULE
def correct(
    calibration: Path,
    targets: Path,
    output: Path,
    units: str | None,
    mapping: Path | None,
    leave_out: bool,
    force: bool,
    effects_modules: Sequence[Path],
) -> None:
    """Correct joint angles so that the real arm takes its sensor where it is wanted.

    The table TARGETS has one row for each pose, in one of two forms:

    \b
      pose,q1..qn          nominal joint angles: the real flange goes where the nominal arm has it
      pose,x,y,z,rx,ry,rz  wanted frames of the sensor in the base frame, as `scalar predict` writes them;
                           or with roll,pitch,yaw or qw,qx,qy,qz in place of rx,ry,rz;
                           q1..qn in the same row give the posture

    Angles are in rad, and lengths in m (see --units). With --mapping, joint angles are those of the controller. Columns that the calibrated effects
    need (approach1..n, temperature, time, order) stand in the same table.

    Cells may be separated by semicolons, with decimal commas; the output is then written so too.

    The output has the joint angles to command, the other columns of TARGETS, and six columns that say how each row was corrected. A row that could
    not be has corrected = 0, a line that says why, and exit status 2.

    docs/own_robot.md, under "What scalar correct reads and writes", has the rest: orientations, postures, singularities, each column.

    \b
    Example:
      scalar correct out/calibration.json program.csv -o corrected.csv --units deg,mm
    """
    from scalar.cli.corrected_targets import correct_targets
    from scalar.cli.targets import read_targets
    from scalar.cli.write_corrected import write_corrected
    from scalar.data.table_units import units_named
    from scalar.estimation.measured_ranges import measured_ranges
    from scalar.estimation.result import load_calibration

    units_named(units)  # refuses units that do not exist before anything is read
    refuse_foreign([(output, table_with("pose", "q1", "near_singular"))], force, [calibration, targets])
    load_effects(effects_modules)
    calibrated = load_calibration(calibration)
    convention = convention_of(mapping, calibrated.model.nominal)
    wanted = read_targets(targets, calibrated.model.robot, units, convention)
    corrected = correct_targets(calibrated.model, wanted, leave_out, measured_ranges(calibrated.summary))
    for line in _lines_before_writing(calibrated, corrected, leave_out):
        say(line)
    n_written = write_corrected(output, corrected, leave_out)
    whose_frame = (
        [line_on_wanted_frames(calibrated.model.T_flange_sensor)]
        if wanted.frames_wanted
        else lines_on_tool(calibrated.gauge, calibrated.model.nominal)
    )
    for line in whose_frame:
        say(line)
    failed = bool(corrected.refused) and not leave_out
    n_corrected = int(corrected.found.reached.sum())
    imported = calibrated.summary.get(IMPORTED, {})
    for line in lines_on_convention(
        convention, _tables(wanted, output), imported, calibrated.model.nominal.name
    ):
        say(line)
    say_written(
        output,
        n_written,
        "pose",
        (f", {n_corrected} of them corrected" if failed else "") + wanted.text_form.in_words,
    )
    if failed:
        raise InvalidInput(faults_of(corrected.refused, str(targets)))


def _tables(targets: Targets, output: Path) -> str:
    """Return which tables have joint angles, in words with their verb."""
    return f"{targets.path.name} and {output.name} have" if targets.joints_given else f"{output.name} has"


def _lines_before_writing(
    calibration: Calibration, corrected: CorrectedTargets, leave_out: bool
) -> list[str]:
    """Return the lines on doubtful units, rows that are left out, and joint angles that deserve a look before they are commanded."""
    from scalar.cli.pose_lines import (
        lines_on_large_changes,
        lines_on_measured_columns,
        lines_on_measured_ranges,
        lines_on_moves,
        lines_on_setup,
    )

    targets, ids, near = corrected.targets, corrected.ids, corrected.sensitivity
    given, q, robot = corrected.poses.q, corrected.found.q, calibration.model.robot
    lines = list(targets.doubts)
    if not targets.frames_wanted:
        lines += lines_on_setup(calibration)
    if leave_out:
        lines += lines_on_left_out(corrected.refused)
    lines += warnings_on_written(robot, ids, corrected.found, near, targets.convention)
    if not targets.frames_wanted:
        was, is_now = (
            q if targets.convention is None else targets.convention.to_controller(q) for q in (given, q)
        )
        lines += lines_on_large_changes(robot, ids, was, is_now, takes_large_turns(near))
    outside = lines_on_measured_ranges(calibration, q)
    lines += outside
    lines += lines_on_measured_columns(calibration, targets.table)
    lines += lines_on_moves(calibration, targets.table)
    if outside and not targets.joints_given:
        lines.append(_CHOSEN)
    return lines
