"""The words on the scale of an arm of which no length is known, or of which all lengths come from the scanner alone."""

from __future__ import annotations

from scalar.estimation.result import Calibration
from scalar.estimation.scanner_scale import NATURAL, SCANNER_SCALE_SHIFT
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


def scanner_scale_in_words(judged: Calibration) -> str:
    """Return how far an error of the scanner's scale would move predicted positions, where nothing in the data checks that scale; else nothing."""
    shift = judged.summary.get(SCANNER_SCALE_SHIFT)
    if shift is None:
        return ""
    return (
        f"nothing in these data checks the scale of the scanner: if it measures {100 * NATURAL:g} % too long or too short, as scanners may, "
        f"predicted positions are off by about {number(shift / MM, 1)} mm (RMS), and no standard error contains that shift. Check the scanner "
        "against a known length, or measure where the planes stand in the base frame and declare them as known in dataset.yaml"
    )


def if_scale_is_right(judged: Calibration) -> str:
    """Return the end of a sentence on an error of positions that holds only if the scanner measures lengths rightly; empty where data check that."""
    shift = judged.summary.get(SCANNER_SCALE_SHIFT)
    if shift is None:
        return ""
    moved = f"{100 * NATURAL:g} % of it moves positions by about {number(shift / MM, 1)} mm"
    return f", if the scanner's scale is right, which nothing in these data checks ({moved})"
