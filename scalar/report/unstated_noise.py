"""The sentence on a residual that nothing can be compared with, because the dataset states no noise and its poses show none.

``usual_noise`` judges whether such a residual can be noise at all.
"""

from __future__ import annotations

from scalar.estimation.result import Calibration
from scalar.estimation.setup.tables.computed_positions import COMPUTED
from scalar.estimation.usual_noise import compared_with_noise, residuals_are_alike
from scalar.report.words import number
from scalar.sensors.registry import kind_named
from scalar.units import MM


def unstated_noise_in_words(calibration: Calibration) -> str:
    """Return what instruments of the kind scatter by, what the rest of the residual means, and what to do.

    Nothing is said if the noise is known, or if the positions were probably computed: then the residual says nothing of instrument and arm.
    """
    usual = kind_named(calibration.sensor["kind"]).usual_noise
    computed = any(suspicion["what"] == COMPUTED for suspicion in calibration.summary.get("setup", ()))
    if usual is None or computed or compared_with_noise(calibration):
        return ""
    known = f"{usual.words}, and an arm repeats its poses to 0.02 to 0.1 mm"
    of_all = " over all axes" if "axis" in usual.words else ""
    residual = f"{number(calibration.residual_rms / MM)} mm{of_all}"
    if calibration.residual_rms > usual.most:
        return (
            f"a residual of {residual} is more than noise of such instruments as a rule: {known}. If yours scatters by as much, state "
            "sensor.noise in dataset.yaml; else the rest is what the model lacks (gears, deflection, temperature) or gross errors: run "
            "'scalar diagnose', which looks for it"
        )
    if residuals_are_alike(calibration):
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
