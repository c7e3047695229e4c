"""The sentence on directions that the planes of a dataset do not show, or hardly."""

from __future__ import annotations

from math import asin

import numpy as np

from scalar.data.formats import FEW_PLANES
from scalar.estimation.result import Calibration
from scalar.estimation.unseen_directions import UNSEEN_DIRECTIONS
from scalar.report.words import capital, listed, number
from scalar.units import DEG, MM


def unseen_directions_in_words(judged: Calibration) -> str:
    """Return which directions the planes do not show, and what is known of positions along them; nothing if they show all."""
    found = judged.summary.get(UNSEEN_DIRECTIONS)
    if not found:
        return ""
    along = listed(
        [f"[{' '.join(f'{x + 0.0:.2f}' for x in np.round(one, 2))}]" for one in found["directions"]]
    )
    if found["seen"]:
        lean = f"{asin(min(found['seen'], 1.0)) / DEG:.1f} degrees"
        said = f"the planes hardly show a shift of the sensor along {along} of the base frame: their normals lean into it by {lean}"
    else:
        said = f"the planes do not show a shift of the sensor along {along} of the base frame"
    near = judged.summary.get("kept_near_data_sheet")
    said += (
        "; what these poses leave open is left to the data sheet"
        if near
        else "; other poses show what moves it there, since they turn the links otherwise"
    )
    if found["std_along_m"] is not None:
        said += (
            f". At the measured poses, predicted positions have a standard error of {number(found['std_along_m'] / MM, 2)} mm along it and "
            f"{number(found['std_across_m'] / MM, 2)} mm along each of the other directions"
        )
    if near and judged.model.nominal.tolerance is None:
        said += (
            ". State robot.tolerance in dataset.yaml if you know it: without it, how far the arm is from its data sheet is estimated from "
            "these data, and few poses show it badly"
        )
    return said + ("" if judged.summary.get(FEW_PLANES) else ". A plane that faces that way would show it")


def unseen_directions_sentences(judged: Calibration) -> list[str]:
    """Return the same as sentences of a page: one paragraph, or none."""
    said = unseen_directions_in_words(judged)
    return [f"{capital(said)}."] if said else []
