"""The residual that noise alone would leave, and the scatter of whole scans beyond the noise of their points."""

from __future__ import annotations

from scalar.diagnosis.fitted_state import FittedState


def floor(state: FittedState) -> float:
    """Return the root mean square distance [m] that the noise within scans alone would leave."""
    measurement = state.residuals.measurement
    return measurement.noise_floor(state.residuals.kinematics(state.model).T_base_sensor, state.model.target)


def between_scans(state: FittedState) -> float:
    """Return the standard deviation [m] by which scans as a whole scatter beyond the noise of their points; zero if they do not."""
    background = state.background_within_scans()
    return state.residuals.measurement.between_poses(background.residual, background.variance)
