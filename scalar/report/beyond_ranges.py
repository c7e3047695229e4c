"""The report's sentences on predictions away from the measured poses: how far they may err, open questions included."""

from __future__ import annotations

from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.io.atomic import plain
from scalar.diagnosis.accuracy.expected_errors import expected_errors
from scalar.geometry.se3 import Array
from scalar.planning.left_open import LeftOpen, left_open
from scalar.report.lead_in import IN_MEASURED_RANGES, ONLY_LIKE_MEASURED
from scalar.report.words import length, listed, quoted
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.diagnosis.result import Diagnosis

MUCH_FARTHER = 3.0  # chosen: ratio of the error over the joint limits to that within the measured ranges beyond which the sentence is given
_ONE_DIRECTION = 20 * DEG  # chosen: the tool is said to keep its direction if no pose tilts it further
_COUNTS = 1.2  # chosen: open questions are mentioned if they raise the error of the found model by more than this factor
_OF_POSITION = 3  # equations of a pose that measures a position; an error along one direction cannot be compared with one of the position
_SHOWN = 3  # effects in question that are named


def beyond_ranges(diagnosis: Diagnosis) -> list[str]:
    """Return sentences if predictions err much more within the measured ranges of the joints than at the measured poses, or over all limits."""
    shipped, expected = diagnosis.shipped, expected_errors(diagnosis)
    found, measured = expected.within_limits.value, expected.within_ranges.value
    errors = diagnosis.errors_after
    at_measured = (errors["unseen_rms_mm"] or errors["held_out_rms_mm"] or 0.0) * MM
    sees_position = diagnosis.before.residuals.measurement.equations_per_pose >= _OF_POSITION
    if sees_position and measured > MUCH_FARTHER * at_measured:
        return [_only_at_such_poses(diagnosis.cleaned.dataset, at_measured, measured)]
    more = None if shipped.without_effects else error_left_open(diagnosis)
    counts = more is not None and more.error > _COUNTS * found
    if (more.error if more is not None and counts else found) <= MUCH_FARTHER * measured:
        return []
    begin = f"{IN_MEASURED_RANGES}: there, predictions are expected to err by {length(measured)} RMS, but by "
    if more is None or not counts:
        return [f"{begin}{length(found)} over the whole of the joint limits."]
    titles = list(dict.fromkeys(quoted(effect.title) for effect in more.effects))
    rest = [f"{len(titles) - _SHOWN} more"] if len(titles) > _SHOWN else []
    return [
        f"{begin}{length(more.error)} over the whole of the joint limits. The model that was found accounts for {length(found)} of this; the rest is "
        f"what these data leave open, at the size that was found or is usual: {listed([*titles[:_SHOWN], *rest])}."
    ]


def _only_at_such_poses(dataset: Dataset, at_measured: float, within_ranges: float) -> str:
    """Return the sentence on poses that combine the joints in few ways, so that their ranges say little.

    Args:
        dataset: The measured poses.
        at_measured: Error at unseen or held-out poses, as it is stated [m].
        within_ranges: Expected error of predictions at random poses within the ranges of the joints [m].
    """
    tilt = _largest_tilt(dataset.robot.flange(dataset.q)[:, :3, :3])
    degrees = max(1, ceil(tilt / DEG))
    why = "the measured poses combine the joints in few of the ways that these ranges allow; measure other combinations"
    if tilt < _ONE_DIRECTION:
        why = (
            f"an axis of the tool kept its direction to within {degrees} degree{'' if degrees == 1 else 's'}, which shows only some combinations of "
            "the joints; measure poses with the tool tilted in other directions"
        )
    return (
        f"{ONLY_LIKE_MEASURED}: there, predictions err by {length(at_measured)}. At random poses within the "
        f"same ranges of the joints they are expected to err by {length(within_ranges)}, because {why} if the arm is to be right there too."
    )


def _largest_tilt(rotations: Array) -> float:
    """Return how far rotations ``(N, 3, 3)`` tilt the axis of the flange whose direction they change least: the largest angle to its mean [rad]."""
    _, _, Vt = np.linalg.svd(rotations.mean(axis=0))
    axes = rotations @ Vt[0]
    mean = axes.mean(axis=0)
    return float(np.arctan2(np.linalg.norm(np.cross(axes, mean), axis=1), axes @ mean).max())


def error_left_open(diagnosis: Diagnosis) -> LeftOpen | None:
    """Return how far predictions may err because of what a diagnosis left open; None if it found nothing, or left nothing open."""
    return _left_open(diagnosis) if diagnosis.findings else None


@lru_cache(maxsize=1)
def _left_open(diagnosis: Diagnosis) -> LeftOpen | None:
    mapping = plain(diagnosis.to_mapping())
    return left_open(diagnosis.dataset, diagnosis.calibration_after, mapping)
