"""Corrected joint angles for a table of poses, whose order tells from which pose the arm reaches each one.

An effect may depend on the move from the previous pose. The arm then moves between corrected poses, so the correction is repeated with the moves
between these until they no longer change. A few rounds suffice: a move changes by milliradians, and its effect by a thousandth of that.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.moves import last_move_columns
from scalar.data.poses import Poses
from scalar.estimation.correction.correct import Correction, correct_frames, correct_joints
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import pandas as pd

_ROUNDS = 8
_SAME_MOVE = 1e-6  # rad: moves that differ by less count as equal; their effects then differ by some nanometres at a lever of a metre


def correct_table(
    model: Model,
    table: pd.DataFrame,
    T_wanted: Array | None = None,
    settings: CorrectionSettings | None = None,
) -> Correction:
    """Return corrected joint angles for a table of poses.

    Args:
        model: The calibrated one.
        table: Columns q1..qn [rad] and the optional columns of poses.csv.
        T_wanted: ``(N, 4, 4)``, frames of the sensor to be taken from postures near q; the nominal arm's at q if None.
        settings: Thresholds; the defaults if None.

    Raises:
        InvalidInput: A column that an effect needs is missing.
    """
    n, slides = model.robot.n_joints, model.robot.slides
    poses = Poses.from_frame(table, slides, order_is_row=False)
    names = [name for name in last_move_columns(n) if name in poses.columns]

    def corrected() -> Correction:
        if T_wanted is None:
            return correct_joints(model, poses, settings)
        return correct_frames(model, poses, T_wanted, settings)

    found = corrected()
    acting = [name for name in names if name not in table.columns]  # moves that the table states are kept
    if not acting or not model.effects:
        return found
    changed = np.zeros(len(poses))
    for _ in range(_ROUNDS):
        commanded = table.assign(**{f"q{i + 1}": found.q[:, i] for i in range(n)})
        moves = Poses.from_frame(commanded, slides, order_is_row=False).columns
        changed = np.max([np.abs(moves[name] - poses.columns[name]) for name in acting], axis=0)
        if np.max(changed) < _SAME_MOVE:
            return found
        poses = replace(poses, columns=moves)
        found = corrected()
    return replace(found, reached=found.reached & (changed < _SAME_MOVE))
