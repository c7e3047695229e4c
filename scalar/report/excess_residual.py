"""The excess of the residual over the noise, which errors outside the model cause: the covariance of a calibration does not cover it.

The residual of an incomplete model exceeds the noise. The excess at the measured poses, as a distance, is counted in every error over the
workspace. Where a diagnosis names it as a random error of whole poses or scans, it is no error of the model: that error is reported on its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.diagnosis.shipped_fit import BY_COMPONENT
from scalar.estimation.misfit import lacks_something, misfit, unexplained_shift
from scalar.estimation.result import Calibration

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis


def excess_distance(calibration: Calibration) -> float:
    """Return the root mean square distance [m] by which the residual of a calibration exceeds the noise; zero unless it clearly does."""
    summary = calibration.summary
    return float(summary.get("misfit_shift_m", 0.0)) if lacks_something(summary) else 0.0


def excess_distance_after(diagnosis: Diagnosis) -> float:
    """Return the same distance [m] for ``after.json``; zero if the diagnosis names the excess as a random error.

    If poses are weighted by a variance component, the weighted residual no longer shows the excess. If the component is not confirmed as a random
    error, or has no name, the excess is taken from the residual with equal weights, even if its p-value alone would not show it.
    """
    shipped = diagnosis.shipped
    named = bool(diagnosis.reported_noise) and not diagnosis.noise_without_a_name
    if named and not shipped.without_effects:
        return 0.0
    if shipped.fit != BY_COMPONENT:
        return excess_distance(diagnosis.calibration_after)
    state = shipped.choice.state
    return unexplained_shift(state.residuals, state.model, misfit(state.residuals, state.model, state.free))


def cause_of_excess(diagnosis: Diagnosis) -> str:
    """Return as a clause what may cause a residual that exceeds the noise where no finding explains it."""
    if diagnosis.after.residuals.measurement.scans:
        return "something that these data do not name"
    return "a noise that is larger than stated, or something that these data do not name"


def excess_beside_findings(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence if the residual clearly exceeds the noise although every finding is in the model and has a name; else none."""
    summary = diagnosis.calibration_after.summary
    told = diagnosis.reported_noise or diagnosis.verdict != "effect" or diagnosis.shipped.without_effects
    if told or not diagnosis.findings or not lacks_something(summary):
        return []
    return [
        f"With what was found in the model, the residual is still {summary['misfit']:.1f} times what the noise explains, because of "
        f"{cause_of_excess(diagnosis)}. A confidence does not say that nothing else acts; what was not recorded (directions of approach, "
        "temperature, payload) may show what else does."
    ]
