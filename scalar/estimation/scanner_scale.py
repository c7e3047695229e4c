"""The scale of a scanner that nothing in the data checks: its error stretches the whole arm, leaves no residual, and is in no standard error.

Where the places of the target planes are only guessed, all lengths of the calibrated arm come from the scanner. If its ranges are too long by
0.1 %, so are the links, and every position is off by 1 mm for each metre. Known places of the planes would show it, and so may scans whose ranges
and angles vary enough to distinguish a wrong scale from a wrong arm. An effect of the catalogue describes such an error
(``Effect.stretches_lengths``). Computed here is how far an error of its natural size moves predicted positions, if the data do not determine it.
"""

from __future__ import annotations

import numpy as np

from scalar.effects.registry import BUILT_IN
from scalar.estimation.displacement import position_std, without_rigid_motion
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.random_poses import random_joints
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

SCALE = next(kind for kind in BUILT_IN if kind.stretches_lengths)
"""The effect that is an error of the scale."""
NATURAL = SCALE.natural["m/m"]
"""Standard deviation of a scanner's scale before anything is measured, as a share of all lengths."""
# Chosen, a share of the natural size: with a smaller standard deviation, the data determine the scale.
DETERMINED = 0.5
SCANNER_SCALE_SHIFT = "scanner_scale_shift_m"
"""Key of a calibration's summary: what ``unchecked_scale`` returns."""
_POSES = 200


def unchecked_scale(residuals: Residuals, model: Model, free: Array, covariance: Array) -> float | None:
    """Return how far predicted positions move if the scanner's scale is off by its natural size [m], RMS over random poses within the joint limits.

    The rigid motion of the base that fits this best is subtracted. None is returned if the sensor measures no ranges, if the model contains their
    scale, or if the data determine it.

    Args:
        residuals: Of the dataset, whitened at the optimum.
        model: Where the fit ended.
        free: ``(P,)`` bool, in the order of ``model.names``.
        covariance: ``(F, F)`` of the free parameters, for residuals of unit variance.
    """
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    by_scale = residuals.measurement.by_range_scale(T_base_sensor, model.target)
    if by_scale is None or any(isinstance(effect, SCALE) for effect in model.effects):
        return None
    known = residuals.linearise(model)[1][:, free]
    column = np.zeros(len(known))
    # The rows below are prior information, which the scale does not change.
    column[: by_scale.size] = by_scale.ravel()
    absorbed = covariance @ (known.T @ column)
    left = float(np.linalg.norm(column - known @ absorbed))
    if left * DETERMINED * NATURAL > 1.0:
        return None
    vector = model.vector.copy()
    vector[free] -= NATURAL * absorbed
    poses, no_effects = random_joints(model, _POSES), EffectBases([], [], [], [])
    here, there = (
        Kinematics.of(m, poses, no_effects).T_base_sensor for m in (model, model.with_vector(vector))
    )
    return position_std(without_rigid_motion(here, (there - here)[:, :3, 3].reshape(-1, 1)), np.eye(1))
