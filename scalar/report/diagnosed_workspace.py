"""The section of a diagnosis on the errors of the arm over its workspace, with what the diagnosis left open."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.accuracy.discrepancy_of_fit import discrepancy_of_shipped
from scalar.diagnosis.accuracy.expected_errors import expected_errors
from scalar.diagnosis.noise.repeated_poses import RepeatedPoses, repeated_poses
from scalar.evaluate.workspace_errors import (
    MEAN_OVER_RMS,
    NOMINAL,
    WorkspaceErrors,
    errors_within_limits,
    mean_over_poses,
)
from scalar.report import words
from scalar.report.beyond_ranges import error_left_open
from scalar.report.lead_in import BY_DATA_SHEET
from scalar.report.scale_words import if_scale_is_right
from scalar.report.workspace_map import (
    SHIPPED,
    WITHOUT_EFFECTS,
    banded_in_words,
    most_errors,
    section_of_errors,
)

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.diagnosis.result import Diagnosis
    from scalar.estimation.model import Model

_CHANCE = 0.01  # chosen: with a right noise, one report in a hundred says that the scatter of repeated poses disagrees with it


@lru_cache(maxsize=1)
def errors_over_workspace(diagnosis: Diagnosis) -> WorkspaceErrors | None:
    """Return the errors of the data sheet, of ``after.json`` and, where it differs, of ``before.json``; None if the fit has no covariance.

    The report and the line of a fleet's table both state them; for one diagnosis they are computed once.
    """
    before, after = diagnosis.calibration_before.model, diagnosis.calibration_after
    models = {WITHOUT_EFFECTS: before} if after.model.effects else {}
    measured_poses = diagnosis.after.residuals.poses
    return errors_within_limits(
        after, models | {SHIPPED: after.model}, measured_poses, discrepancy_of_shipped(diagnosis)
    )


def diagnosed_workspace(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the section on errors over the workspace, with the error that the diagnosis left open; None if there is no such section."""
    errors = errors_over_workspace(diagnosis)
    if errors is None:
        return None
    measured_poses, discrepancy = diagnosis.after.residuals.poses, discrepancy_of_shipped(diagnosis)
    section = section_of_errors(diagnosis.calibration_after, errors, measured_poses, SHIPPED, discrepancy)
    if section is None:
        return None
    section["now"] = before_and_after_in_words(diagnosis)
    section["within_ranges"] = expected_within_ranges(diagnosis)
    section["repeated"] = repeated_in_words(diagnosis.cleaned.dataset, diagnosis.calibration_before.model)
    if diagnosis.shipped.without_effects or (more := error_left_open(diagnosis)) is None:
        return section
    return section | {
        "left_open": words.length(MEAN_OVER_RMS * float(np.hypot(more.error, discrepancy.excess)))
    }


@lru_cache(maxsize=1)  # the report and the terminal both state it
def before_and_after_in_words(diagnosis: Diagnosis) -> str:
    """Return the sentence on how wrong the arm is as its data sheet describes it, and how wrong with ``after.json``; empty where this is unknown."""
    errors = errors_over_workspace(diagnosis)
    if errors is None:
        return ""
    data_sheet, shipped = (errors.all_sizes[model] for model in (NOMINAL, SHIPPED))
    before, after = banded_in_words(data_sheet, mean_over_poses), banded_in_words(shipped, mean_over_poses)
    return (
        f"{BY_DATA_SHEET} the arm errs by {before['value']} in the mean over its workspace (95 of 100 poses by less than "
        f"{banded_in_words(data_sheet, most_errors)['value']}), and with {SHIPPED} by {after['value']} (95 % band {after['band']}), with the best "
        f"base and tool frame for each{if_scale_is_right(diagnosis.calibration_after)}."
    )


def expected_within_ranges(diagnosis: Diagnosis) -> str:
    """Return the sentence on the error that is expected within the ranges of the joints that were measured, with its band if it has one."""
    expected = expected_errors(diagnosis)
    error, band = expected.within_ranges, ""
    if expected.has_bands:
        band = f", 95 % band {words.length(error.low)} to {words.length(error.high)}"
    return (
        f"At random poses within the ranges of the joints that were measured, {SHIPPED} is expected to err by {words.length(error.value)} (root mean "
        f"square{band}), with its own tool frame and the best base frame."
    )


def repeated_in_words(dataset: Dataset, model: Model) -> str:
    """Return the sentence on how far the points of poses scatter to which the arm came back; empty if too few were repeated.

    Args:
        dataset: What was measured.
        model: Calibrated with it.
    """
    found = repeated_poses(dataset, model)
    if found is None:
        return ""
    poses = "one pose" if found.poses == 1 else f"{found.poses} poses"
    return (
        f"Repeated poses scatter by {words.length(found.scatter)} (root mean square; the arm came back {found.returns} times, to {poses}). "
        "This is the least error of any model of the joint angles: it holds the arm's repeatability, the noise of the tracker, and what changed "
        f"in between.{_compared_with_stated_noise(found)}"
    )


def _compared_with_stated_noise(found: RepeatedPoses) -> str:
    """Return a sentence if the stated noise contradicts the scatter of repeated poses, or explains only a part of it; else nothing."""
    if found.by_stated_noise is None:
        return ""
    freedom = 3 * found.freedom  # of single coordinates
    least, most = np.sqrt(chi2.ppf([_CHANCE / 2, 1 - _CHANCE / 2], freedom) / freedom) * found.by_stated_noise
    alone = f"The stated noise alone would scatter them by {words.length(found.by_stated_noise)}"
    if found.scatter < least:
        return f" {alone}, which is more: the noise is stated too large, and nothing in this diagnosis was decided by the comparison."
    if found.scatter > most:
        return (
            f" {alone}; the rest is the arm's repeatability and what changed in between, unless the noise is stated too small. Nothing in this "
            "diagnosis was decided by the comparison."
        )
    return ""
