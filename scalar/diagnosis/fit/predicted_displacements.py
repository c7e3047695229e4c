"""Displacements of predicted positions when parameters of a fitted state change, at poses that need not be measured.

The best rigid motion of all positions is removed from the displacements, because a motion of the base is no error of the arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects import Effect
from scalar.estimation.displacement import displacement_columns as model_columns
from scalar.estimation.random_poses import limits_or_measured_ranges, poses_within_limits, ranges_of_joints
from scalar.geometry.se3 import Array

N_POSES = 1500
_SEED = 20240


def joint_limits(state: FittedState) -> Array:
    """Return the joints' limits ``(n, 2)`` [rad, or m of a joint that slides]; the measured range of a joint without limits."""
    return limits_or_measured_ranges(state.model.nominal.limits, state.residuals.poses.q)


def measured_ranges(state: FittedState) -> Array:
    """Return the measured ranges of the joints ``(n, 2)`` [rad, or m of a joint that slides]."""
    return ranges_of_joints(state.residuals.poses.q)


def random_poses(state: FittedState, count: int = N_POSES) -> Poses:
    """Return random poses within the joint limits, the same in every call; the other columns have measured values."""
    return poses_within(joint_limits(state), state, count)


def poses_within(limits: Array, state: FittedState, count: int) -> Poses:
    """Return random poses within ranges of the joints ``(n, 2)`` [rad or m], the same in every call; the other columns have measured values."""
    return poses_within_limits(limits, state.residuals.poses, count, _SEED)


def poses_measured(state: FittedState, count: int) -> Poses:
    """Return measured poses, at most ``count``, spread evenly over the acquisition."""
    poses = state.residuals.poses
    some = np.unique(np.linspace(0, len(poses) - 1, min(count, len(poses))).round().astype(int))
    return Poses(
        poses.q[some], poses.order[some], {name: values[some] for name, values in poses.columns.items()}
    )


def displacement_columns(state: FittedState, poses: Poses, more: Sequence[Effect] = ()) -> Array:
    """Return the derivatives ``(3 N, P + k)`` of predicted positions [m] by all parameters, the best rigid motion removed from each.

    Args:
        state: The fitted state.
        poses: The N poses at which positions are predicted.
        more: Effects that the state does not have; their k coefficients follow those of its model.
    """
    return model_columns(replace(state.model, effects=(*state.model.effects, *more)), poses)
