"""The noise of a sensor that takes too few readings at a pose to see its own noise: it is estimated from what a model leaves.

Where a noise is stated, it is kept as long as the residual is not clearly smaller. A larger residual proves nothing, since the model may lack an
effect. A smaller one proves that the noise is stated too large, and such a statement would hide effects and keep the arm at its data sheet.
"""

from __future__ import annotations

import numpy as np

from scalar.sensors.pose_noise import POSITION_NOISE, NoiseComponent
from scalar.units import MM

_ENOUGH = 20  # degrees of freedom from which the size of a residual says something: 16 % standard error
_CLEARLY_SMALLER = 0.8  # of the stated noise; less differs no more than data sheets of one instrument do
_STANDARD_ERRORS = 4.0  # by which the residual has to be smaller as well; one data set in 30,000 is by chance
UNCHANGED = 1e-3  # a smaller relative change of an estimated noise is not applied


def noise_factor(rms: float, rows: int, unknowns: int, *, stated: bool) -> float:
    """Return the factor by which an assumed noise is multiplied to agree with a residual; 1 where it is kept.

    Args:
        rms: Root mean square of the residual, in standard deviations of the assumed noise, scaled up for the parameters of the fit.
        rows: Number of measured rows.
        unknowns: Approximate number of parameters that the fit estimates.
        stated: Whether the assumed noise is stated.
    """
    freedom = rows - unknowns
    if freedom < _ENOUGH:
        return 1.0
    smaller = rms < min(_CLEARLY_SMALLER, 1.0 - _STANDARD_ERRORS / np.sqrt(2.0 * freedom))
    if (stated and not smaller) or abs(rms - 1.0) < UNCHANGED:
        return 1.0
    return rms


def scaled_up(rms: float, rows: int, unknowns: int) -> float:
    """Return the root mean square of a residual, scaled up because a fit adapts its parameters to the noise (Förstner's estimator)."""
    return rms * float(np.sqrt(rows / max(rows - unknowns, rows / 2)))


def estimated_position_noise(value: float, rows: int, stated: float | None) -> NoiseComponent:
    """Return an estimated noise of positions as files list it.

    Args:
        value: Its standard deviation [m], of a coordinate or a contact.
        rows: Number of measured rows.
        stated: What was stated [m], or None.
    """
    sentence = (
        f"the noise of a measured position is estimated from what the model leaves, {value / MM:.3g} mm"
    )
    if stated is not None:
        sentence += f"; the stated {stated / MM:.3g} mm are too large"
    return NoiseComponent(POSITION_NOISE, {}, value, value / float(np.sqrt(2.0 * rows)), "m", sentence)
