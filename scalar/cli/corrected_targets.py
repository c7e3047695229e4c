"""Correct the targets of ``scalar correct``, and leave out those that the arm cannot take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from scalar.cli.correct_words import Uncorrected, brought_as_near, cannot_take, faults_of
from scalar.cli.kinds_of_targets import naming_cells, naming_table
from scalar.cli.targets import Targets, frames_of
from scalar.data.poses import Poses
from scalar.errors import InvalidInput
from scalar.estimation.correction import (
    Correction,
    Sensitivity,
    brought_near,
    correct_table,
    nearest_to_frames,
    sensitivity,
    takes_whole_poses,
)
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class CorrectedTargets:
    """The targets that have joint angles to command, and why the others do not.

    Attributes:
        targets: The targets, with a posture for each row.
        rows: ``(M,)``, indices of the rows of their table that have joint angles to command.
        poses: The M poses as they were asked for.
        ids: ``(M,)``, their numbers.
        found: Their corrected joint angles.
        sensitivity: How far each of them is from a singularity.
        refused: A record for each row that the arm cannot take exactly, in the order of the table.
    """

    targets: Targets
    rows: Array
    poses: Poses
    ids: Array
    found: Correction
    sensitivity: Sensitivity
    refused: list[Uncorrected]


@dataclass(frozen=True, eq=False)
class _Attempt:
    """The correction of some rows of a table.

    Attributes:
        poses: As they were asked for.
        ids: ``(M,)``, their numbers.
        exact: The correction that takes the frames exactly where that is possible.
        found: The same, with the nearest joint angles where that is not possible.
        given: The errors at the joint angles as they were given; None if frames were wanted.
        is_near: ``(M,)`` bool, which poses are not taken exactly but have joint angles that come near.
    """

    poses: Poses
    ids: Array
    exact: Correction
    found: Correction
    given: Correction | None
    is_near: Array

    def marked(self) -> list[Uncorrected]:
        """Return a record for each pose that is not taken exactly."""
        return [
            brought_as_near(self.ids[i], self.found, self.given, int(i))
            for i in np.flatnonzero(~self.found.reached)
        ]


def correct_targets(
    model: Model, targets: Targets, leave_out: bool, measured: Array | None = None
) -> CorrectedTargets:
    """Return the targets with the joint angles at which the calibrated arm takes them.

    A row without any such joint angles is left out of the moves from pose to pose, which effects may depend on. The correction of the other rows is
    therefore repeated without it.

    Args:
        model: The calibrated one.
        targets: What is wanted.
        leave_out: Whether rows that the arm takes only nearly are left out as well.
        measured: ``(n, 2)`` [rad; m where a joint slides], the ranges over the measured poses, in which postures are preferred; or None.

    Raises:
        InvalidInput: No row can be corrected, or a column that an effect needs is missing.
    """
    targets, rows, dropped = targets.with_postures(model, measured)
    while True:
        if not len(rows):
            raise InvalidInput(faults_of(dropped, str(targets.path), is_written=False))
        attempt = _attempted(model, targets, targets.table.iloc[rows].reset_index(drop=True))
        kept = attempt.found.reached | (attempt.is_near & (not leave_out))
        if kept.all():
            break
        dropped += [cannot_take(attempt.ids[i], attempt.exact, int(i)) for i in np.flatnonzero(~kept)]
        rows = rows[kept]
    refused = [*dropped, *attempt.marked()]
    whole_poses = takes_whole_poses(model.robot.n_joints)
    if targets.frames_wanted and whole_poses and not attempt.found.reached.any():
        raise InvalidInput(faults_of(refused, str(targets.path), is_written=False))
    near = sensitivity(model, attempt.poses, attempt.found.q)
    row_of = {pose: i for i, pose in enumerate(targets.table["pose"].to_numpy())}
    refused.sort(key=lambda one: row_of[one.pose])
    return CorrectedTargets(targets, rows, attempt.poses, attempt.ids, attempt.found, near, refused)


def _attempted(model: Model, targets: Targets, table: pd.DataFrame) -> _Attempt:
    """Return the correction of some rows of the targets, given as a table of their own."""
    with naming_table(targets.path.name), naming_cells(table, model.robot):
        exact = correct_table(model, table, frames_of(table) if targets.frames_wanted else None)
    poses = Poses.from_frame(table, model.robot.slides, order_is_row=False)
    if targets.frames_wanted:
        given = None
        found, is_near = nearest_to_frames(model, poses, exact)
    else:
        found, given = brought_near(model, poses, exact)
        is_near = ~found.reached
    return _Attempt(poses, table["pose"].to_numpy(), exact, found, given, is_near)
