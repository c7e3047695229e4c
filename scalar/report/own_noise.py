"""Report the noise within scans in sentences and a picture: whether it comes from the scanner, from the surface, or from both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.effects.picture import Axis
from scalar.report import words
from scalar.report.axes import range_of
from scalar.report.pictures import Pair, panel_of, sentences

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis
    from scalar.sensors.pose_noise import Autocorrelation

_BAND = 2.0  # half the width of the band of white noise, in standard errors


def own_noise(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the sentences and the picture of the noise within poses; None if it is white and the same for all points."""
    noise = diagnosis.after.rows.noise
    if noise is None:
        return None
    return {
        "sentences": [words.capital(component.sentence) for component in noise.components],
        "picture": draw_autocorrelation(noise.autocorrelation),
    }


def draw_autocorrelation(autocorrelation: Autocorrelation) -> Pair:
    """Return the correlation of the errors of points of one scan over their distance in points, with the band of white noise."""
    measured, band = autocorrelation.measured, _BAND * autocorrelation.band
    lag = np.arange(1, len(measured) + 1, dtype=float)
    x_axis, y_axis = Axis("points apart", ""), Axis("correlation of the points' errors", "")
    panel = panel_of(
        x_axis, y_axis, (0.0, float(lag[-1]) + 1.0), range_of([measured, band, -band], around_zero=True), ""
    )
    panel.band(lag, -band, band, "ink")
    panel.line(lag, measured, "blue", behind=True)
    labels = [
        f"{k:.0f} points apart: {words.number(value, 2)}" for k, value in zip(lag, measured, strict=True)
    ]
    panel.marks(lag, measured, labels, "blue", size=6.0)
    what = (
        "correlation of the errors of two points of a scan about its own curve, over their distance in points"
    )
    return Pair(
        panel.markup(what),
        None,
        sentences(f"{what}.", "If the errors are independent, 19 of 20 dots lie within the grey band."),
        (("●", "blue", "what was measured"), ("■", "band", "what independent points show by chance")),
    )
