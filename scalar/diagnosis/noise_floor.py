"""What the noise alone would leave of the distances, and what whole scans are off beyond the noise of their points."""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.sensors.line_laser import LineLaser


def floor(state: FittedState) -> float:
    """Return the root mean square distance [m] that the noise within scans alone would leave."""
    measurement = state.residuals.measurement
    if not isinstance(measurement, LineLaser):
        return measurement.sigma * float(np.sqrt(measurement.rows_per_pose))
    return measurement.noise_floor(state.residuals.kinematics(state.model).T_base_sensor, state.model.target)


def between_scans(state: FittedState) -> float:
    """Return the standard deviation [m] of what a scan as a whole is off, beyond the noise of its points; zero where it is not."""
    measurement = state.residuals.measurement
    background = state.background_within_scans()
    excess = max(background.variance - 1.0, 0.0)
    if not isinstance(measurement, LineLaser):
        return float(np.sqrt(excess)) * measurement.sigma
    # The first profile row is the whitened mean: its length in metres is one over the norm of the weights.
    weights = np.abs(measurement.R[:, 0, 0])
    first = np.mean(background.residual[:, 0] ** 2) - 1.0
    return float(np.sqrt(max(first, 0.0))) / float(np.sqrt(np.mean(weights**2)))
