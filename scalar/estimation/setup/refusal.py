"""Refuse data that do not fit their own description, and say what would make them fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.motion import still_clause
from scalar.data.rounding import rounded_angles
from scalar.errors import Undetermined
from scalar.estimation.setup.suspicion import WrongSetup, explain
from scalar.geometry.se3 import Array
from scalar.units import MM


def refuse_wrong_setup(dataset: Dataset) -> None:
    """Refuse a dataset if another reading of its set-up explains it far better; do nothing if none does.

    Raises:
        WrongSetup: With that reading, and the residual before and after.
    """
    suspicions = explain(dataset)
    if suspicions:
        first = replace(suspicions[0], sentence=suspicions[0].sentence + still_clause(dataset.q))
        raise WrongSetup((first, *suspicions[1:]))


def misfit_refused(dataset: Dataset, distances: Array) -> Undetermined:
    """Return the refusal of a fit that leaves larger residuals than any effect of an arm causes.

    Args:
        dataset: What was measured.
        distances: ``(N,)`` [m], as ``Residuals.pose_distances`` gives them.
    """
    planes, label = (" or the planes", ", label") if dataset.planes else ("", "")
    robot = "the robot, the sensor" if dataset.planes else "the robot or the sensor"
    moved = "planes or base" if dataset.planes else "tracker or base, an exchange of the target"
    worst = int(dataset.pose_ids[np.argmax(distances)])
    residual = float(np.sqrt(np.mean(distances**2)))
    rounded = rounded_angles(dataset.robot, dataset.q, residual)
    first = f"{rounded}. If they are exact, " if rounded else ""
    return Undetermined(
        [f"the best fit is still {residual / MM:.0f} mm RMS off, pose {worst} most of all: {first}this is not "
         f"{robot}{planes} that dataset.yaml describes. These were tried, and none explains it: one wrong sign, zero, length, unit{label} or "
         "convention; a sign and a zero of one joint; two zeros; two or three signs; rows of measurements that are moved or lost; a move of "
         f"{moved}. Check first whether joint angles and measurements belong together, row by row, and then whether several of these are wrong at "
         "once"
         f"{still_clause(dataset.q)}"]
    )  # fmt: skip
