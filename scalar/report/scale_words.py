"""The words on the scale of an arm of which no length is known."""

from __future__ import annotations

from scalar.estimation.result import Calibration
from scalar.estimation.unknown_scale import unknown_scale
from scalar.report.parameter_table import in_rows
from scalar.report.words import number
from scalar.units import MM


def scale_in_words(judged: Calibration) -> str:
    """Return which length is taken from the data sheet, and how wrong it may be, where no length is known; else nothing."""
    found = unknown_scale(judged)
    if found is None:
        return ""
    return (
        f"{in_rows(found.name, judged.model.nominal)}, which is taken from the data sheet; the figures count an error of it of "
        f"{number(found.std / MM, 2)} mm (one standard deviation, {number(100 * found.relative, 2)} % of all lengths)"
    )
