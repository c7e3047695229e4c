"""The residual that noise alone would leave, and how far whole scans scatter beyond the noise of their points.

If the noise is neither stated nor observable within a pose (a tracker measures one point), it is estimated from the residual of the model.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.noise.repeated_poses import repeated_poses
from scalar.units import MM


def within_scans(state: FittedState) -> float:
    """Return the standard deviation [m] of a point, or of a coordinate of a tracked point."""
    return state.residuals.measurement.sigma * _scale(state)


def noise_floor(state: FittedState) -> float:
    """Return the root mean square distance [m] of points from the model that the noise within scans alone would leave."""
    measurement = state.residuals.measurement
    pose = state.residuals.kinematics(state.model).T_base_sensor
    return measurement.noise_floor(pose, state.model.target) * _scale(state)


def between_scans(state: FittedState) -> float:
    """Return the standard deviation [m] by which scans as a whole scatter beyond the noise of their points; zero if they do not."""
    background, measurement = state.background_within_scans(), state.residuals.measurement
    return (
        measurement.between_poses(background.residual, background.variance)
        if measurement.sigma_known
        else 0.0
    )


def noise_entry(state: FittedState) -> dict[str, Any]:
    """Return the entry of ``diagnosis.json`` on the noise, and on the scatter of poses to which the arm came back (null if they do not tell)."""
    repeated = repeated_poses(state.dataset, state.model)
    return {
        "within_scan_mm": within_scans(state) / MM,
        "between_scans_mm": between_scans(state) / MM,
        "repeated_poses_mm": None if repeated is None else repeated.scatter / MM,
        "components": [component.to_mapping() for component in state.residuals.measurement.listed_noise],
    }


def _scale(state: FittedState) -> float:
    """Return the ratio of the noise to that for which the rows are whitened; it is one if the noise is known."""
    known = state.residuals.measurement.sigma_known
    return 1.0 if known else float(np.sqrt(state.background_within_scans().variance))
