"""Sentences on a residual that exceeds the noise, and on what may cause that."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.estimation.misfit import lacks_something
from scalar.estimation.usual_noise import exceeds_usual_noise
from scalar.report.words import number
from scalar.sensors.registry import kind_named
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis


def cause_of_excess(diagnosis: Diagnosis) -> str:
    """Return as a clause what may cause a residual that exceeds the noise where no finding explains it."""
    if diagnosis.after.residuals.measurement.scans:
        return "something that these data do not name"
    return "a noise that is larger than stated, or something that these data do not name"


def more_than_instrument(diagnosis: Diagnosis) -> str:
    """Return as a clause that the residual is no noise of the instrument, where no noise is stated; else empty."""
    calibration = diagnosis.calibration_after
    usual = kind_named(calibration.sensor["kind"]).usual_noise
    if usual is None or not exceeds_usual_noise(calibration):
        return ""
    if calibration.residual_rms > usual.most:
        return f"the residual of {number(calibration.residual_rms / MM)} mm is more than the noise of an instrument ({usual.words})"
    return "similar poses leave similar residuals, which noise does not"


SCATTER_OF_WHAT = (
    "Measure some poses several times, far apart in time: if the readings of one pose differ by as much as the residual, instrument, target or arm "
    "scatter; if they agree, something acts at each pose that these data do not name. Use after.json with care at other poses."
)
"""What to do about such a residual that no effect explains."""


def unexplained_excess(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence if the residual clearly exceeds the noise although every finding is in the model and has a name; else none."""
    summary = diagnosis.calibration_after.summary
    reported = diagnosis.reported_noise or diagnosis.verdict != "effect" or diagnosis.shipped.without_effects
    if reported or not diagnosis.findings or not lacks_something(summary):
        return []
    return [
        f"With what was found in the model, the residual is still {summary['misfit']:.1f} times what the noise explains, because of "
        f"{cause_of_excess(diagnosis)}. A confidence does not say that nothing else acts; what was not recorded (directions of approach, "
        "temperature, payload) may show what else does."
    ]
