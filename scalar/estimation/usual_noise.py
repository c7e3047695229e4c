"""Compare the residual of a calibration whose noise is not known with the noise that instruments of its kind usually have.

The noise is then estimated from the residual itself, so what the model lacks counts as noise. Two things show it all the same: the residual is larger
than instruments of the kind scatter by, or the residuals of similar poses are alike, which noise does not make them (the design effect).
"""

from __future__ import annotations

from scalar.estimation.result import Calibration
from scalar.sensors.registry import kind_named


def exceeds_usual_noise(calibration: Calibration) -> bool:
    """Return whether the noise is not known, and the residual is no noise: larger than such instruments scatter, or alike at similar poses."""
    usual = kind_named(calibration.sensor["kind"]).usual_noise
    if usual is None or compared_with_noise(calibration):
        return False
    return calibration.residual_rms > usual.most or residuals_are_alike(calibration)


def residuals_are_alike(calibration: Calibration) -> bool:
    """Return whether the residuals of similar poses are alike beyond chance."""
    return calibration.summary.get("design_effect", 1.0) > 1.0


def compared_with_noise(calibration: Calibration) -> bool:
    """Return whether the residual was compared with a known noise, or the calibration comes from no fit."""
    return "misfit" not in calibration.summary or calibration.summary.get("misfit_p_value") is not None
