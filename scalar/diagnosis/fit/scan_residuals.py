"""Residuals for pictures, in metres: one number for each pose, and the heights of pieces of each scan over its plane."""

from __future__ import annotations

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects import Effect
from scalar.geometry.se3 import Array
from scalar.sensors import Pieces


def signed_residual(state: FittedState) -> Array:
    """Return one residual for each pose ``(N,)`` [m]: the height over the plane, with its sign, or for other kinds of sensor a distance."""
    rows = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    residual = state.residuals.residual(state.model)[:rows]
    return state.residuals.measurement.shown_residual(residual.reshape(state.dataset.n_poses, -1))


def pieces(state: FittedState, effect: Effect) -> Pieces:
    """Return the heights of pieces of the scans, or of a probe's contacts, over their planes, and what one of the state's effects adds to them.

    Args:
        state: The state with the effect.
        effect: One of its effects on points; the same object.
    """
    residuals = state.residuals
    bound = residuals.point_effects(state.model)
    return residuals.measurement.pieces(
        residuals.kinematics(state.model).T_base_sensor,
        state.model.target,
        bound,
        next(e for e in bound if e.effect is effect),
    )
