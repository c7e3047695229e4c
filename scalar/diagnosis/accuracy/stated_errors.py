"""The errors that ``diagnosis.json`` states: at training poses, at poses held out from the fit, at poses that no part of the diagnosis used, and
where nothing was measured."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.halves_left_out import halves_left_out
from scalar.diagnosis.held_out.hold_out import HeldOutErrors
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.estimation.result import Calibration
from scalar.units import MM


def held_out(
    calibration: Calibration, error: HeldOutErrors, halves: OuterSplit | None = None
) -> dict[str, float]:
    """Return the entry of ``diagnosis.json`` on a calibration's errors at training poses and at held-out poses.

    Args:
        calibration: The calibration.
        error: Its held-out errors.
        halves: Diagnoses of one half of the poses each, or None. If their errors at the other half are larger, they are stated as held-out errors.
    """
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
    """Return the entry of ``diagnosis.json`` on the two runs on one half of the poses each; None without such runs."""
    if halves is None:
        return None
    without, effects = halves.errors
    return {
        "poses": len(halves.fold),
        "without_effects_rms_mm": without.rms / MM,
        "with_effects_rms_mm": effects.rms / MM,
    }


def unseen(outer: OuterSplit | None, which: int, shipped: Calibration) -> dict[str, float | None]:
    """Return the entry of ``diagnosis.json`` on errors at unseen poses, and their standard deviations over the parts; null if they are not known.

    Args:
        outer: The outer split, or None.
        which: 0 for the errors without effects, 1 for those as shipped.
        shipped: The calibration whose errors at its own poses correct the estimate (``OuterSplit.unseen_rms``).
    """
    keys = ("unseen_rms_mm", "unseen_max_mm", "unseen_rms_spread_mm", "unseen_max_spread_mm")
    if outer is None or not len(outer.errors[which].metric):
        return dict.fromkeys(keys)
    error = outer.errors[which]
    values = (outer.unseen_rms(which, shipped.residual_rms), error.largest, *outer.std_over_parts(error))
    return {key: value / MM if np.isfinite(value) else None for key, value in zip(keys, values, strict=True)}


def where_unmeasured(
    shipped: FittedState, before: FittedState, stated: Iterable[float | None]
) -> dict[str, Any] | None:
    """Return the entry of ``diagnosis.json`` on errors where nothing was measured; None with too few poses to halve them.

    Args:
        shipped: The fit that is shipped.
        before: The fit without effects.
        stated: Errors that are stated elsewhere [mm], where they are known: root mean square, at poses like those that were measured and over the
            whole of the joint limits. The error where nothing was measured is no smaller.
    """
    halves, without = halves_left_out(shipped), halves_left_out(before)
    if not halves or not without:
        return None
    worst = halves[0]
    return {
        "rms_mm": max(
            worst.rms / MM, *(error for error in stated if error is not None and np.isfinite(error))
        ),
        "halves": len(halves),
        "median_rms_mm": float(np.median([half.rms for half in halves])) / MM,
        "worst_half": {
            "along": worst.along,
            "upper": worst.upper,
            "poses": worst.poses,
            "rms_mm": worst.rms / MM,
            "chance_rms_mm": worst.chance / MM,
        },
        "without_effects_rms_mm": without[0].rms / MM,
    }
