"""The sentence on a residual that nothing can be compared with, because the dataset states no noise and its poses show none.

The noise is then estimated from the residual itself, so what the model lacks counts as noise. Two things show it all the same: the residual is larger
than instruments of the kind scatter by, or the residuals of similar poses are alike, which noise does not make them (the design effect).
"""

from __future__ import annotations

from scalar.estimation.result import Calibration
from scalar.report.words import number
from scalar.sensors.registry import kind_named
from scalar.units import MM


def exceeds_usual_noise(calibration: Calibration) -> bool:
    """Return whether the noise is not known, and the residual is no noise: larger than such instruments scatter, or alike at similar poses."""
    usual = kind_named(calibration.sensor["kind"]).usual_noise
    if usual is None or _compared(calibration):
        return False
    return calibration.residual_rms > usual.most or _alike(calibration)


def _alike(calibration: Calibration) -> bool:
    """Return whether the residuals of similar poses are alike beyond chance."""
    return calibration.summary.get("design_effect", 1.0) > 1.0


def unstated_noise_in_words(calibration: Calibration) -> str:
    """Return what instruments of the kind scatter by, what the rest of the residual means, and what to do; nothing if the noise is known."""
    usual = kind_named(calibration.sensor["kind"]).usual_noise
    if usual is None or _compared(calibration):
        return ""
    known = f"{usual.words}, and an arm repeats its poses to 0.02 to 0.1 mm"
    of_all = " over all axes" if "axis" in usual.words else ""
    residual = f"{number(calibration.residual_rms / MM)} mm{of_all}"
    if calibration.residual_rms > usual.most:
        return (
            f"a residual of {residual} is more than noise: {known}; the rest is what the model lacks (gears, deflection, temperature) "
            "or gross errors. Run 'scalar diagnose', which looks for it"
        )
    if _alike(calibration):
        return (
            f"a residual of {residual} is more than noise, because similar poses leave similar residuals ({known}); the model lacks something "
            "(gears, deflection, temperature). Run 'scalar diagnose', which looks for it"
        )
    stated = calibration.sensor.get("noise")
    why, do = "no noise is stated", "state sensor.noise in dataset.yaml"
    if stated:
        why = f"the stated noise of {number(stated / MM)} mm explains more than there is"
        do = "correct sensor.noise in dataset.yaml"
    return f"{why}, so the residual of {residual} was not tested: {known}; {do}, and the residual is compared with it"


def _compared(calibration: Calibration) -> bool:
    """Return whether the residual was compared with a known noise, or the calibration comes from no fit."""
    return "misfit" not in calibration.summary or calibration.summary.get("misfit_p_value") is not None
