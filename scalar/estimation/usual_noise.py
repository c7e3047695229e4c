"""Compare the residual of a calibration whose noise is not known with the noise that instruments of its kind usually have.

The noise is then estimated from the residual itself, so what the model lacks counts as noise. Two things show it all the same: the residual is larger
than instruments of the kind scatter by, or the residuals of similar poses are alike, which noise does not make them (the design effect). A third
shows it in one of two campaigns: the noise that was estimated there is larger than in the other.
"""

from __future__ import annotations

import math

from scalar.estimation.result import Calibration
from scalar.sensors.pose_noise import POSITION_NOISE
from scalar.sensors.registry import kind_named

_DIFFERS = 4.0  # standard errors by which the logarithms of two estimated noises differ beyond chance


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


def noisier(one: Calibration, other: Calibration) -> int | None:
    """Return which of two calibrations, 0 or 1, estimated the larger noise from its residual; None if chance explains it, or a noise is known.

    Both were measured by the same kind of sensor, else None.
    """
    estimates = []
    for calibration in (one, other):
        noise = [part for part in calibration.noise if part["name"] == POSITION_NOISE]
        if compared_with_noise(calibration) or len(noise) != 1:
            return None
        estimates.append((float(noise[0]["value"]), float(noise[0]["std"])))
    (a, a_std), (b, b_std) = estimates
    if one.sensor["kind"] != other.sensor["kind"] or min(a, b, a_std, b_std) <= 0.0:
        return None
    difference = math.log(b / a)
    return int(difference > 0) if abs(difference) > _DIFFERS * math.hypot(a_std / a, b_std / b) else None
