"""Refuse data that do not fit their own description, and say what would make them fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.motion import still_clause
from scalar.data.rounding import rounded_angles
from scalar.errors import Undetermined
from scalar.estimation.settings import DEFAULTS, EstimationSettings
from scalar.estimation.setup.explain import explain
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.geometry.se3 import Array
from scalar.units import MM

_MOST_NAMED = 8
"""Most poses that a refusal names, so that they fit in a line."""
_MANY = 0.1  # share of the poses beyond the limits of a joint from which on this is said


def refuse_wrong_setup(dataset: Dataset) -> None:
    """Refuse a dataset if another reading of its set-up explains it far better; do nothing if none does.

    Raises:
        WrongSetup: With that reading, and the residual before and after.
    """
    suspicions = explain(dataset)
    if suspicions:
        first = replace(suspicions[0], sentence=suspicions[0].sentence + still_clause(dataset.q))
        raise WrongSetup((first, *suspicions[1:]))


def misfit_refused(
    dataset: Dataset, distances: Array, settings: EstimationSettings = DEFAULTS, *, diagnosed: bool = False
) -> Undetermined:
    """Return the refusal of a fit that leaves larger residuals than any effect of an arm causes.

    If only a few poses are so far off, they are asked about first, because the description of the set-up concerns all poses.

    Args:
        dataset: What was measured.
        distances: ``(N,)`` [m], as ``Residuals.pose_distances`` gives them.
        settings: From which distance on a pose is a gross error, and which share of the poses may be gross errors.
        diagnosed: Whether a diagnosis refuses; it has set aside what it can, so that nobody is sent to it.
    """
    far = distances > settings.sufficiency.gross_error
    few = 0 < far.sum() <= settings.gross_errors.most_set_aside * len(distances)
    first = (
        _few_far_in_words(dataset, distances, far, diagnosed)
        if few
        else _all_far_in_words(dataset, distances)
    )
    label = ", label" if dataset.planes else ""
    moved = (
        "planes or base"
        if dataset.planes
        else "tracker or base, an exchange of the target; one factor of all positions"
    )
    return Undetermined(
        [f"{first} These were tried, and none explains it: one wrong sign, zero, length, unit{label} or "
         "convention; a sign and a zero of one joint; two zeros; any number of signs; rows of measurements that are moved or lost; a move of "
         f"{moved}.{_limits_clause(dataset)} Check first whether joint angles and measurements belong together, row by row, "
         "and then whether several of these are wrong at once"
         f"{still_clause(dataset.q)}"]
    )  # fmt: skip


def _limits_clause(dataset: Dataset) -> str:
    """Return a sentence on joints that many poses have beyond their limits, as where columns stand in another order; empty if there are none."""
    low, high = dataset.robot.limits.T
    beyond = np.mean((dataset.q < low) | (dataset.q > high), axis=0) > _MANY
    named = [str(j + 1) for j in np.flatnonzero(beyond)]
    if not named:
        return ""
    joints = f"Joint {named[0]} is" if len(named) == 1 else f"Joints {', '.join(named)} are"
    return f" {joints} beyond the limits in many poses: do the columns q1..q{dataset.robot.n_joints} stand in the order of the joints?"


def _all_far_in_words(dataset: Dataset, distances: Array) -> str:
    """Return the sentence about a description that fits hardly any pose."""
    planes = " or the planes" if dataset.planes else ""
    robot = "the robot, the sensor" if dataset.planes else "the robot or the sensor"
    worst = int(dataset.pose_ids[np.argmax(distances)])
    residual = float(np.sqrt(np.mean(distances**2)))
    rounded = rounded_angles(dataset.robot, dataset.q, residual)
    first = f"{rounded}. If they are exact, " if rounded else ""
    return (
        f"the best fit is still {residual / MM:.0f} mm RMS off, pose {worst} most of all: {first}this is not {robot}{planes} that "
        "dataset.yaml describes."
    )


def _few_far_in_words(dataset: Dataset, distances: Array, far: Array, diagnosed: bool) -> str:
    """Return the sentences about single poses, ``far`` ``(N,)``, in a description that fits the others better."""
    worst_first = [int(row) for row in np.argsort(-distances) if far[row]]
    ids = [str(dataset.pose_ids[row]) for row in worst_first[:_MOST_NAMED]]
    more = f" and {len(worst_first) - len(ids)} more" if len(worst_first) > len(ids) else ""
    one = len(worst_first) == 1
    named = f"pose {ids[0]} lies" if one else f"poses {', '.join(ids)}{more} lie up to"
    otherwise = (
        "" if diagnosed else "; 'scalar diagnose' sets single poses aside, if the others agree without them"
    )
    which, this, it = ("one pose", "this pose", "it") if one else ("a few poses", "these poses", "them")
    return (
        f"{named} {distances.max() / MM:.1f} mm from where the best fit has {it}, and half of all poses lie within "
        f"{float(np.median(distances)) / MM:.1f} mm: no effect of an arm makes {which} err so far. Look first whether the joint angles and the "
        f"measurement of {this} belong together, and remove {it} if they do not{otherwise}. "
        f"If {'it is' if one else 'they are'} right, dataset.yaml does not describe what was measured."
    )
