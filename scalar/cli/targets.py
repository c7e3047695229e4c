"""The table TARGETS of ``scalar correct``: joint angles of the nominal arm, or wanted frames of the sensor, with a posture for each row."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from scalar.cli.correct_words import Uncorrected, no_posture
from scalar.cli.kinds_of_targets import (
    naming_mixed_rows,
    refuse_far_places,
    refuse_large_turns,
    refuse_without_orientation,
)
from scalar.cli.options import advice_on_units
from scalar.cli.pose_lines import lines_on_small_degrees, lines_on_small_travels
from scalar.data.io.semicolons import TextForm, form_of_file
from scalar.data.joint_convention import JointConvention
from scalar.data.moves import joint_angles
from scalar.data.pose_tables import read_pose_table
from scalar.data.table_units import TableUnits, base_name, columns_of, units_named, units_to_write
from scalar.estimation.correction import postures_for
from scalar.estimation.frame_tables import (
    FRAME_COLUMNS,
    ORIENTATIONS,
    PLACE,
    form_of_orientation,
    with_rotation_vectors,
)
from scalar.estimation.model import Model
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, transform_from_rotation_vector


@dataclass(frozen=True, eq=False)
class Targets:
    """The targets of ``scalar correct``, as read from their table.

    Attributes:
        path: File of the table.
        table: All rows, in SI units, with the joints of the dataset and with orientations as rotation vectors; its index counts the rows of the file.
        frames_wanted: Whether the rows state wanted frames of the sensor. If not, the frames of the nominal arm at the joint angles are wanted.
        joints_given: Whether the rows state joint angles, at which the nominal arm takes the frame or near which a posture is chosen.
        units: Units in which the corrected table is written.
        text_form: How its cells are separated and its numbers written; the corrected table is written so too.
        doubts: Lines on units that the numbers make doubtful.
        convention: How the controller counts the joints of the tables that are read and written; None if they count as those of the dataset.
    """

    path: Path
    table: pd.DataFrame
    frames_wanted: bool
    joints_given: bool
    units: TableUnits
    text_form: TextForm
    doubts: tuple[str, ...]
    convention: JointConvention | None = None

    def with_postures(
        self, model: Model, measured: Array | None = None
    ) -> tuple[Targets, Array, list[Uncorrected]]:
        """Return the targets with joint angles in all rows, the indices of the rows that can be corrected, and a record for each other row.

        Joint angles that are not given are chosen for the rigid arm, and a row for whose frame there are none cannot be corrected. It has the joint
        angles that come nearest.

        Args:
            model: The calibrated one.
            measured: ``(n, 2)`` [rad; m where a joint slides], the ranges of the joints over the measured poses, or None.
        """
        if self.joints_given:
            return self, np.arange(len(self.table)), []
        q, _ = postures_for(model, frames_of(self.table), measured=measured)
        found = ~np.isnan(q[:, 0])
        refused = [no_posture(pose) for pose in self.table["pose"].to_numpy()[~found]]
        joints = {f"q{i + 1}": q[:, i] for i in range(q.shape[1])}
        return replace(self, table=self.table.assign(**joints)), np.flatnonzero(found), refused


def read_targets(
    path: Path, robot: Robot, units: str | None, convention: JointConvention | None = None
) -> Targets:
    """Return the targets that a table states.

    Args:
        path: CSV file.
        robot: The calibrated arm: how many joints it has, which of them slide, and where it reaches.
        units: Units that the user names for columns without a unit, such as ``deg,mm``; None if the user names none.
        convention: How the controller counts the joints of the table; None if they count as those of the dataset.

    Raises:
        InvalidInput: The table is at fault, or holds numbers that cannot be in the stated units.
    """
    read_in, columns = units_named(units), columns_of(path)
    refuse_without_orientation(columns, path.name)
    named = {base_name(column) for column in columns}
    orientation = form_of_orientation(named)
    frame = (*PLACE, *orientation)
    frames_wanted = bool(named & set(frame))
    joints_given = "q1" in named or not frames_wanted
    with advice_on_units(), naming_mixed_rows(path, columns):
        table = read_pose_table(
            path,
            robot.n_joints,
            frame if frames_wanted else (),
            robot.limits,
            units=read_in.turning(ORIENTATIONS["rpy"]) if frames_wanted else read_in,
            joints_needed=joints_given,
            prismatic=robot.prismatic,
            columns=columns,
            copied=True,
            convention=convention,
        )
    written_in = units_to_write(units, columns, robot.prismatic)
    q = joint_angles(table, robot.n_joints) if joints_given else np.empty((0, robot.n_joints))
    in_file = q if convention is None else convention.to_controller(q)
    doubts = lines_on_small_degrees(robot, in_file, written_in.angle)
    doubts += lines_on_small_travels(robot, in_file, columns, read_in)
    if frames_wanted:
        in_degrees = read_in.angle == "deg" or any(f"{name}_deg" in columns for name in orientation)
        if not in_degrees:
            refuse_large_turns(table, orientation, path.name)
        table = with_rotation_vectors(table, orientation, path.name)
        refuse_far_places(robot, frames_of(table), path.name, read_in.angle)
    units_written = written_in.sliding(robot.prismatic)
    form = form_of_file(path)
    return Targets(path, table, frames_wanted, joints_given, units_written, form, tuple(doubts), convention)


def frames_of(table: pd.DataFrame) -> Array:
    """Return the wanted frames ``(N, 4, 4)`` of a table with orientations as rotation vectors."""
    values = table[list(FRAME_COLUMNS)].to_numpy(dtype=float)
    return transform_from_rotation_vector(values[:, :3], values[:, 3:])
