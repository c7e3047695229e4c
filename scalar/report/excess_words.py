"""Sentences on a residual that exceeds the noise, and on what may cause that."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.estimation.misfit import lacks_something

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis


def cause_of_excess(diagnosis: Diagnosis) -> str:
    """Return as a clause what may cause a residual that exceeds the noise where no finding explains it."""
    if diagnosis.after.residuals.measurement.scans:
        return "something that these data do not name"
    return "a noise that is larger than stated, or something that these data do not name"


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
