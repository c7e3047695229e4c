"""``scalar correct``: joint angles that take the real arm to the wanted frames."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.correct_words import (
    Uncorrected,
    brought_as_near,
    cannot_take,
    faults_of,
    is_near_singular,
    lines_on_left_out,
    lines_on_tool,
    no_posture,
    warnings_on_written,
)
from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, UNITS, advice_on_units, load_effects
from scalar.cli.outputs import FORCE, refuse_foreign, table_with
from scalar.cli.terminal import say, say_written
from scalar.errors import InvalidInput

if TYPE_CHECKING:
    import pandas as pd

    from scalar.data.table_units import TableUnits
    from scalar.estimation.correction import Correction, Sensitivity
    from scalar.estimation.model import Model
    from scalar.geometry.se3 import Array

_CHOSEN = "  each posture was chosen near that of the row before; to choose another one, give its joint angles q1..qn beside the frames"


@cli.command()
@click.argument("calibration", type=PATH)
@click.argument("targets", type=PATH)
@click.option("-o", "--output", type=PATH, required=True, help="CSV file to write.")
@UNITS
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
                           q1..qn beside them give the posture

    Angles are in rad, and lengths in m (see --units). Columns that the calibrated effects need (approach1..n, temperature, time, order) stand
    beside them.

    The output has the joint angles to command, the other columns of TARGETS, and six columns that say how each row was corrected. A row that could
    not be has corrected = 0, a line that says why, and exit status 2.

    docs/own_robot.md, under "What scalar correct reads and writes", has the rest: orientations, postures, singularities, each column.

    \b
    Example:
      scalar correct out/calibration.json program.csv -o corrected.csv --units deg,mm
    """
    import numpy as np

    from scalar.cli.kinds_of_targets import (
        naming_mixed_rows,
        naming_table,
        naming_text,
        refuse_far_places,
        refuse_large_turns,
        refuse_without_orientation,
    )
    from scalar.cli.pose_lines import (
        lines_on_large_changes,
        lines_on_measured_columns,
        lines_on_measured_ranges,
        lines_on_moves,
        lines_on_setup,
        lines_on_small_degrees,
        lines_on_small_travels,
    )
    from scalar.data.io.csv_reader import cells_as_written
    from scalar.data.moves import joint_angles
    from scalar.data.pose_tables import read_pose_table
    from scalar.data.poses import Poses
    from scalar.data.table_units import base_name, columns_of, units_named, units_to_write
    from scalar.estimation.correction import (
        brought_near,
        correct_table,
        nearest_to_frames,
        sensitivity,
        takes_whole_poses,
    )
    from scalar.estimation.frame_tables import ORIENTATIONS, PLACE, form_of_orientation, with_rotation_vectors
    from scalar.estimation.result import load_calibration

    in_units = units_named(units)
    refuse_foreign([(output, table_with("pose", "q1", "near_singular"))], force, [calibration, targets])
    load_effects(effects_modules)
    calibrated = load_calibration(calibration)
    model = calibrated.model
    robot = model.robot
    columns = columns_of(targets)
    refuse_without_orientation(columns, targets.name)
    named = {base_name(column) for column in columns}
    form = form_of_orientation(named)
    frame = (*PLACE, *form)
    frames_wanted = bool(named & set(frame))
    with_joints = "q1" in named or not frames_wanted
    with advice_on_units(), naming_mixed_rows(targets, columns):
        table = read_pose_table(
            targets,
            robot.n_joints,
            frame if frames_wanted else (),
            robot.limits,
            units=in_units.turning(ORIENTATIONS["rpy"]) if frames_wanted else in_units,
            joints_needed=with_joints,
            prismatic=robot.prismatic,
            columns=columns,
            copied=True,
        )
    angles = joint_angles(table, robot.n_joints) if with_joints else np.empty((0, robot.n_joints))
    written_in = units_to_write(units, columns, robot.prismatic)
    unsure = lines_on_small_degrees(robot, angles, written_in.angle)
    unsure += lines_on_small_travels(robot, angles, columns, in_units)
    rows, dropped = np.arange(len(table)), []
    if frames_wanted:
        stated = in_units.angle == "deg" or any(f"{name}_deg" in columns for name in form)
        if not stated:
            refuse_large_turns(table, form, targets.name)
        table = with_rotation_vectors(table, form, targets.name)
        refuse_far_places(robot, _frames(table), targets.name)
        if not with_joints:
            table, rows, dropped = _with_postures(model, table)
    while True:
        if not len(rows):
            raise InvalidInput(faults_of(dropped, str(targets), is_written=False))
        going = table.iloc[rows].reset_index(drop=True)
        with naming_table(targets.name), naming_text(going):
            found = correct_table(model, going, _frames(going) if frames_wanted else None)
        poses = Poses.from_frame(going, robot.n_joints, order_is_row=False)
        ids, given, exact = going["pose"].to_numpy(), None, found
        if frames_wanted:
            found, nearly = nearest_to_frames(model, poses, found)
        else:
            found, given = brought_near(model, poses, found)
            nearly = ~found.reached
        kept = found.reached | (nearly & (not leave_out))
        if kept.all():
            break
        dropped += [cannot_take(ids[i], exact, int(i)) for i in np.flatnonzero(~kept)]
        rows = rows[kept]  # the moves of the others are those without these rows
    if frames_wanted and takes_whole_poses(robot.n_joints) and not found.reached.any():
        marked = [brought_as_near(ids[i], found, given, int(i)) for i in range(len(ids))]
        raise InvalidInput(faults_of([*dropped, *marked], str(targets), is_written=False))
    marked = [brought_as_near(ids[i], found, given, int(i)) for i in np.flatnonzero(~found.reached)]
    refused = _in_order([*dropped, *marked], table)
    near = sensitivity(model, poses, found.q)
    for line in [
        *unsure,
        *([] if frames_wanted else lines_on_setup(calibrated)),
        *(lines_on_left_out(refused) if leave_out else []),
        *warnings_on_written(robot, ids, found, near),
        *(
            []
            if frames_wanted
            else lines_on_large_changes(robot, ids, poses.q, found.q, is_near_singular(near))
        ),
        *(outside := lines_on_measured_ranges(calibrated, found.q)),
        *lines_on_measured_columns(calibrated, table),
        *lines_on_moves(calibrated, table),
        *([_CHOSEN] if outside and not with_joints else []),
    ]:
        say(line)
    written = table.iloc[rows] if leave_out else table
    cells = cells_as_written(targets)
    _write(output, written, cells, rows, found, near, written_in.sliding(robot.prismatic))
    if not frames_wanted:
        for line in lines_on_tool(calibrated.gauge, calibrated.model.nominal):
            say(line)
    corrected = int(found.reached.sum())
    failed = bool(refused) and not leave_out
    say_written(output, len(written), "pose", f", {corrected} of them corrected" if failed else "")
    if failed:
        raise InvalidInput(faults_of(refused, str(targets)))


def _frames(table: pd.DataFrame) -> Array:
    """Return the wanted frames ``(N, 4, 4)`` of a table."""
    from scalar.estimation.frame_tables import FRAME_COLUMNS
    from scalar.geometry.se3 import transform_from_rotation_vector

    values = table[list(FRAME_COLUMNS)].to_numpy(dtype=float)
    return transform_from_rotation_vector(values[:, :3], values[:, 3:])


def _with_postures(model: Model, table: pd.DataFrame) -> tuple[pd.DataFrame, Array, list[Uncorrected]]:
    """Return the table with joint angles of the rigid arm, the rows that have such, and the message for each of the others.

    Where no posture takes a frame, the joint angles are those that come nearest.
    """
    import numpy as np

    from scalar.estimation.correction import postures_for

    q, _ = postures_for(model, _frames(table))
    found = ~np.isnan(q[:, 0])
    refused = [no_posture(pose) for pose in table["pose"].to_numpy()[~found]]
    joints = {f"q{i + 1}": q[:, i] for i in range(q.shape[1])}
    return table.assign(**joints), np.flatnonzero(found), refused


def _in_order(refused: list[Uncorrected], table: pd.DataFrame) -> list[Uncorrected]:
    """Return the records in the order of the table's rows."""
    row = {pose: i for i, pose in enumerate(table["pose"].to_numpy())}
    return sorted(refused, key=lambda one: row[one.pose])


def _with_unit(name: str, units: TableUnits, like: str) -> str:
    """Return the name of a column that has the unit of the column ``like``."""
    return f"{name}{units.named(like).removeprefix(like)}"


def _write(
    path: Path,
    table: pd.DataFrame,
    cells: dict[str, list[str]],
    rows: Array,
    found: Correction,
    near: Sensitivity,
    units: TableUnits,
) -> None:
    """Write the joint angles, with the other columns of the table and the columns that say how each pose was corrected.

    Args:
        path: File to write.
        table: The targets of all rows that are written; its index counts the rows of the file TARGETS.
        cells: The cells of the columns of that file as they are written there.
        rows: ``(M,)``, in the same count, the rows that have joint angles.
        found: The M corrected joint angles.
        near: Their sensitivity near singularities.
        units: Units of the columns.
    """
    import numpy as np
    import pandas as pd

    from scalar.data.io.atomic import atomic_write
    from scalar.estimation.frame_tables import ORIENTATIONS, is_frame_column

    of_frames = {c for form in ORIENTATIONS.values() for c in form} if "x" in table.columns else set()
    positions = np.searchsorted(table.index.to_numpy(), rows)

    def full_column(values: Array, empty: object = "") -> Array:
        """Return a column of all rows, with these values in the rows that have joint angles."""
        if len(positions) == len(table):
            return values
        column = np.full(len(table), empty, dtype=object)
        column[positions] = values
        return column

    joints = [f"q{i + 1}" for i in range(found.q.shape[1])]
    columns = {"pose": table["pose"].to_numpy()}
    for i, name in enumerate(joints):
        columns[units.named(name)] = full_column(found.q[:, i] / units.of(name)[1])
    own = {
        "corrected": full_column(found.reached.astype(int), 0),
        "beyond_limits": full_column(found.beyond_limits.sum(axis=1)),
        "near_singular": full_column(is_near_singular(near).astype(int)),
        "smallest_singular_value": full_column(near.singular_value),
        _with_unit("position_error", units, "x"): full_column(found.position_error / units.of("x")[1]),
        _with_unit("orientation_error", units, "rx"): full_column(
            found.orientation_error / units.of("rx")[1]
        ),
    }
    for name in table.columns:
        if name not in ("pose", *joints, *own, *of_frames) and not is_frame_column(str(name)):
            columns[name] = [cells[name][i] for i in table.index] if name in cells else table[name].to_numpy()
    columns |= own
    with atomic_write(path) as temporary:
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.15g")
