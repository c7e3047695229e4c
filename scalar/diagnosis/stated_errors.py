"""The errors that ``diagnosis.json`` states: of training poses, of poses held out from the fit, and of poses that no part of the diagnosis used."""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.hold_out import HeldOutErrors
from scalar.diagnosis.outer_split import OuterSplit
from scalar.estimation.result import Calibration
from scalar.units import MM


def held_out(
    calibration: Calibration, error: HeldOutErrors, halves: OuterSplit | None = None
) -> dict[str, float]:
    """Return the errors of a calibration; errors of poses that the diagnosis of one half has not seen count if they are larger."""
    rms, largest = error.rms, error.largest
    if halves is not None:
        rms = max(rms, halves.unseen_rms(1, calibration.residual_rms))
        largest = max(largest, halves.errors[1].largest)
    return {
        "train_rms_mm": calibration.residual_rms / MM,
        "held_out_rms_mm": rms / MM,
        "held_out_max_mm": largest / MM,
    }


def of_halves(halves: OuterSplit | None) -> dict[str, float] | None:
    """Return what ``diagnosis.json`` says of the two runs on one half of the poses each."""
    if halves is None:
        return None
    without, effects = halves.errors
    return {
        "poses": len(halves.fold),
        "without_effects_rms_mm": without.rms / MM,
        "with_effects_rms_mm": effects.rms / MM,
    }


def unseen(outer: OuterSplit | None, which: int, shipped: Calibration) -> dict[str, float | None]:
    """Return the errors on poses that nothing has seen, and their spread over the parts; null where they are not known."""
    keys = ("unseen_rms_mm", "unseen_max_mm", "unseen_rms_spread_mm", "unseen_max_spread_mm")
    if outer is None or not len(outer.errors[which].metric):
        return dict.fromkeys(keys)
    error = outer.errors[which]
    values = (outer.unseen_rms(which, shipped.residual_rms), error.largest, *outer.std_over_parts(error))
    return {key: value / MM if np.isfinite(value) else None for key, value in zip(keys, values, strict=True)}
