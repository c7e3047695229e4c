"""Residuals for pictures, in metres and with a sign: heights over planes, and scans cut in pieces."""

from __future__ import annotations

from scalar.diagnosis.fitted_state import FittedState
from scalar.effects import Effect
from scalar.geometry.se3 import Array
from scalar.sensors import Pieces


def signed_residual(state: FittedState) -> Array:
    """Return each pose's residual ``(N,)`` [m], as its kind of sensor shows it: a height over the plane, or a distance without a sign."""
    rows = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    residual = state.residuals.residual(state.model)[:rows]
    return state.residuals.measurement.shown_residual(residual.reshape(state.dataset.n_poses, -1))


def pieces(state: FittedState, effect: Effect) -> Pieces:
    """Return the scans in pieces, or a probe's contacts, with what one of the state's effects on points adds."""
    residuals = state.residuals
    bound = residuals.point_effects(state.model)
    return residuals.measurement.pieces(
        residuals.kinematics(state.model).T_base_sensor,
        state.model.target,
        bound,
        next(e for e in bound if e.effect is effect),
    )
