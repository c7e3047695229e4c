"""``scalar predict``: the sensor's frame for every row of a table of joint angles."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.convention import MAPPING, convention_of, lines_on_convention
from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, UNITS, advice_on_units, load_effects
from scalar.cli.outputs import FORCE, refuse_foreign, table_with
from scalar.cli.pose_lines import frames_if, lines_on_doubts
from scalar.cli.terminal import say, say_written
from scalar.data.formats import IMPORTED
from scalar.units import MM

if TYPE_CHECKING:
    import pandas as pd

    from scalar.data.joint_convention import JointConvention
    from scalar.data.table_units import TableUnits
    from scalar.estimation.result import Calibration
    from scalar.geometry.se3 import Array

_LACKS = (
    "  the model lacks something: the standard errors contain only the chance errors of the measurements, and the arm may err by several times as "
    "much (`scalar diagnose` looks for it)"
)

_WORTH_SAYING = 0.01 * MM  # chosen: no tracker or scanner measures less


@cli.command()
@click.argument("calibration", type=PATH)
@click.argument("joints", type=PATH)
@click.option("-o", "--output", type=PATH, required=True, help="CSV file to write.")
@click.option(
    "--std",
    "with_std",
    is_flag=True,
    help="Also write, for every pose, the standard deviations x_std..rz_std of its six components and the correlation of each pair of components.",
)
@click.option(
    "--target",
    metavar="NAME",
    help="Target whose frame is predicted, if several were measured on one flange; the first if not given.",
)
@click.option(
    "--orientation",
    "orientations",
    type=click.Choice(["rpy", "quaternion"]),
    multiple=True,
    help="Also write the orientation as roll,pitch,yaw (Rz(yaw) Ry(pitch) Rx(roll); KUKA's C, B, A) or as qw,qx,qy,qz; may be given again.",
)
@UNITS
@MAPPING
@FORCE
@EFFECTS_MODULE
def predict(
    calibration: Path,
    joints: Path,
    output: Path,
    with_std: bool,
    target: str | None,
    orientations: Sequence[str],
    units: str | None,
    mapping: Path | None,
    force: bool,
    effects_modules: Sequence[Path],
) -> None:
    """Predict the sensor's frame for joint angles.

    All calibrated effects are applied. The table JOINTS has pose,q1..qn [rad; m where a joint slides], pose
    a whole number, and the optional columns of poses.csv. The output has pose,x,y,z,rx,ry,rz [m, rotation vector in
    rad], the frame of the sensor in that of the base. With --std it also
    has the standard deviations [m, rad] of a shift and of a small rotation in the base frame. They are the uncertainty that
    the calibration contributes; repeatability is not included. Fixed parameters are taken as exact. Probes, and tracker targets
    without measured orientation, do not determine their rotation
    on the flange: rx,ry,rz are then those of the declared mount, and have no standard deviation.

    Neither a laser tracker, whose place is unknown, nor planes that are not declared `known` show where the base stands. Frames are then right
    relative to one another, but their common place in the base frame follows from the parameters that were fixed (gauge in
    CALIBRATION): if the zero of joint 1 is wrong by 90 degrees, all frames are turned by 90 degrees about its axis, and nothing in the data shows
    it. If that matters, measure three points whose place in the base frame is known.

    Poses at which a joint is beyond its limits are predicted too; the command lists them. Poses clearly outside the ranges of the joints that were
    measured are counted: no measurement shows how large the error of the arm is there.

    With --units deg,mm the joint angles are read in degrees (the travel of a joint that slides in mm), and x_mm..rz_deg are
    written. With --units deg, or columns q1_deg..qn_deg, lengths are written in mm as well, unless a travel is read in m.
    A column whose name states no unit is in m or rad.

    Cells may be separated by semicolons, with decimal commas; the output is then written so too.

    With --mapping, q1..qn are the joint angles as the controller counts them, and approach1..n its directions.

    \b
    Example:
      scalar predict out/calibration.json joints.csv -o frames.csv --std
      scalar predict out/calibration.json joints.csv -o frames.csv --units deg,mm --orientation rpy
      scalar predict out/calibration.json joints.csv -o frames.csv --units deg,mm --mapping my-tracker.yaml
    """
    from scalar.cli.kinds_of_targets import naming_cells, naming_table, refuse_frames
    from scalar.data.io.semicolons import form_of_file
    from scalar.data.pose_tables import read_pose_table
    from scalar.data.table_units import columns_of, units_named, units_to_write
    from scalar.estimation.frame_tables import write_frames
    from scalar.estimation.result import load_calibration

    read_in = units_named(units)
    refuse_foreign([(output, table_with("pose", "x", "rz"))], force, [calibration, joints])
    load_effects(effects_modules)
    calibrated = load_calibration(calibration)
    robot = calibrated.model.robot
    columns = columns_of(joints)
    refuse_frames(columns, joints.name)
    convention = convention_of(mapping, calibrated.model.nominal)
    with advice_on_units():
        table = read_pose_table(
            joints,
            robot.n_joints,
            limits=robot.limits,
            units=read_in,
            prismatic=robot.prismatic,
            columns=columns,
            copied=True,
            convention=convention,
        )
    with naming_table(joints.name), naming_cells(table, robot):
        covariance = calibrated.predict_covariance(table, target=target) if with_std else None
        frames = calibrated.predict(table, target=target)
    written_in, text_form = units_to_write(units, columns, robot.prismatic), form_of_file(joints)
    write_frames(
        output,
        table["pose"].to_numpy(),
        frames,
        covariance,
        units=written_in,
        orientation_known=calibrated.observes_orientation,
        also=orientations,
        text_form=text_form,
    )
    say_written(output, len(table), "pose", written_in.in_words + text_form.in_words)
    imported = calibrated.summary.get(IMPORTED, {})
    for line in (
        *lines_on_doubts(calibrated),
        *lines_on_convention(convention, f"{joints.name} has", imported, robot.name),
        *_lines_on_orientation(calibrated),
        *_lines_on_times(calibrated, columns, table, frames if target is None else None),
        *_lines_on_table(calibrated, table, columns, read_in, written_in, convention),
        *(_lines_on_std(calibrated) if with_std else ()),
    ):
        say(line)


def _lines_on_table(
    calibration: Calibration,
    table: pd.DataFrame,
    columns: Sequence[str],
    read_in: TableUnits,
    written_in: TableUnits,
    convention: JointConvention | None,
) -> list[str]:
    """Return the lines on doubtful units, and on poses of which the calibration knows little.

    Args:
        calibration: With which the frames were predicted.
        table: The poses.
        columns: Names in the first line of their file.
        read_in: Units of the columns there whose names state none.
        written_in: Units of the frames.
        convention: How the controller counts the joints of the file; None if they count as those of the dataset.
    """
    from scalar.cli.pose_lines import (
        lines_on_limits,
        lines_on_measured_columns,
        lines_on_measured_ranges,
        lines_on_moves,
        lines_on_small_degrees,
        lines_on_small_travels,
    )
    from scalar.data.moves import joint_angles

    robot = calibration.model.robot
    q = joint_angles(table, robot.n_joints)
    in_file = q if convention is None else convention.to_controller(q)
    return [
        *lines_on_small_degrees(robot, in_file, written_in.angle),
        *lines_on_small_travels(robot, in_file, columns, read_in),
        *lines_on_limits(robot, table["pose"].to_numpy(), q, convention),
        *lines_on_measured_ranges(calibration, q),
        *lines_on_measured_columns(calibration, table),
        *lines_on_moves(calibration, table),
    ]


def _lines_on_orientation(calibration: Calibration) -> list[str]:
    """Return one line if the measurements do not show how the sensor is turned on the flange; else none."""
    from scalar.sensors import kind_named

    if calibration.observes_orientation:
        return []
    kind = kind_named(calibration.sensor["kind"]).words
    return [
        f"  the measurements of a {kind} do not show how its frame is turned on the flange: orientations are those of the declared mount, and have "
        "no standard deviation"
    ]


def _lines_on_times(
    calibration: Calibration, columns: Sequence[str], table: pd.DataFrame, frames: Array | None
) -> list[str]:
    """Return what the frames contain because the table states an order or a time, or because it states none.

    Args:
        calibration: With which the frames were predicted.
        columns: Names in the first line of the table's file.
        table: The poses.
        frames: ``(N, 4, 4)``, those that were predicted; None for those of another target: then nothing is said without an order.
    """
    if {"order", "time"} & set(columns):
        said = sorted({effect.in_timed_predictions for effect in calibration.model.effects} - {""})
        return [f"  {clause}" for clause in said]
    if frames is None or not calibration.model.effects:
        return []
    moved = _moved_since_the_start(calibration, table, frames)
    if moved < _WORTH_SAYING:
        return []
    return [
        "  the table has no column order, so the frames are those after the last measured pose; at the first one they were up to "
        f"{moved / MM:.2g} mm from there"
    ]


def _moved_since_the_start(calibration: Calibration, table: pd.DataFrame, frames: Array) -> float:
    """Return how far effects that grow or begin during a campaign move a predicted position at most [m], from its first pose to its end."""
    import numpy as np

    at_start = frames_if(calibration, table, order=0.0)
    return float(np.linalg.norm((frames - at_start)[:, :3, 3], axis=1).max(initial=0.0))


def _lines_on_std(calibration: Calibration) -> list[str]:
    """Return the lines on what the standard deviations do not contain."""
    from scalar.estimation.misfit import lacks_something
    from scalar.report.scale_words import scanner_scale_in_words

    scale = scanner_scale_in_words(calibration)
    return [*([_LACKS] if lacks_something(calibration.summary) else []), *([f"  {scale}"] if scale else [])]
