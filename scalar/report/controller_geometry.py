"""Which of the two calibrations suits a controller that takes lengths and angles but no effects.

Both are compared with after.json and its effects, the best estimate of the arm: the geometry of before.json, which was fitted without effects, and
that of after.json with the effects left out. Base and tool are taught again for each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.estimation.displacement import kinematics_at
from scalar.estimation.model import Model
from scalar.estimation.random_poses import limits_or_measured_ranges, poses_within_limits
from scalar.evaluate.workspace_errors import aligned_errors
from scalar.export.rigid_part import rigid_part
from scalar.report.words import length

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

_POSES, _SEED = 500, 71
_NOTHING_LEFT = 1e-9
"""Mean error [m] below which the geometry of after.json is taken to hold all effects; rounding alone makes less."""


def better_in_controller(diagnosis: Diagnosis) -> tuple[str, str] | None:
    """Return the file whose geometry errs less without effects, and a clause with both mean errors; None if that of after.json holds all effects."""
    after, measured_poses = diagnosis.calibration_after.model, diagnosis.after.residuals.poses
    poses = poses_within_limits(
        limits_or_measured_ranges(after.nominal.limits, measured_poses.q), measured_poses, _POSES, _SEED
    )
    part = rigid_part(
        after, {name: float(np.median(values)) for name, values in measured_poses.columns.items()}
    )
    geometries = {
        "before.json": diagnosis.calibration_before.model,
        "after.json": Model.at(part.robot, part.T_flange_sensor, after.target),
    }
    T = kinematics_at(after, poses).T_base_sensor
    errors = {
        file: float(
            np.linalg.norm(aligned_errors(kinematics_at(model, poses).T_base_sensor, T), axis=1).mean()
        )
        for file, model in geometries.items()
    }
    if errors["after.json"] < _NOTHING_LEFT:
        return None
    better, worse = sorted(errors, key=lambda file: errors[file])
    return (
        better,
        f"it then errs by {length(errors[better])} on average over the joint limits, with those of {worse} by {length(errors[worse])}, base and tool "
        "taught again",
    )
