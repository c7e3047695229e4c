"""Set gross errors aside before a diagnosis: points off the line of their scan, poses that contradict the others, wrong plane labels.

Nothing is deleted from the user's files; what is set aside is listed. An error is gross if it is far larger than what effects on an arm cause
(millimetres instead of tenths) and occurs at scattered poses. A run of successive poses that are all off is a change of the set-up, not a row of
outliers, and stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.acquisition import order_and_time
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.line_breakdown import share_of_broken_lines
from scalar.estimation.outlying_points import without_outlying_points
from scalar.estimation.plane_labels import other_labels
from scalar.estimation.pose_consistency import (
    coarsely_consistent,
    finely_consistent,
    in_runs,
    outlier_limit,
    refuse_lost_session,
)
from scalar.estimation.settings import DEFAULTS, EstimationSettings, GrossErrorSettings
from scalar.estimation.trimmed_start import with_estimated_pose
from scalar.estimation.turned_orientations import not_turned
from scalar.geometry.se3 import Array
from scalar.sensors.robust_scale import robust_std


@dataclass(frozen=True, eq=False)
class Cleaned:
    """A dataset without its gross errors, and what was set aside.

    Attributes:
        dataset: What remains.
        outlier_poses: Ids of poses that contradict the others and lie on no other plane.
        mislabelled_poses: Ids of poses that lie on another plane than their label says, with the name of that plane.
        points: Number of points set aside within the remaining scans.
        direction_unknown: Ids of poses that are right, but the moves to them are not known, and an effect that was found depends on these.
    """

    dataset: Dataset
    outlier_poses: tuple[int, ...]
    mislabelled_poses: tuple[tuple[int, str], ...]
    points: int
    direction_unknown: tuple[int, ...] = ()


class TooManyStrayPoints(Undetermined):
    """So many points are stray that the lines of the scans are lost. The cause is known, so signs, zeros and units need not be searched for it."""


def without_stray_points(
    dataset: Dataset, settings: GrossErrorSettings = DEFAULTS.gross_errors
) -> tuple[Dataset, int, Array]:
    """Return the dataset without points off their own scan's line, their number, and which scans are corrupted, ``(N,)`` bool.

    Raises:
        TooManyStrayPoints: More than ``most_set_aside`` of the scans have so many stray points that they show no line.
    """
    dataset, count, corrupted = without_outlying_points(dataset, settings)
    share = share_of_broken_lines(dataset, corrupted, settings)
    if share > settings.most_set_aside:
        raise TooManyStrayPoints(
            [f"in {100 * share:.0f} % of the scans so many points lie off any common line that nothing tells which points are right: look for "
             "reflections, for edges of the planes within the scans, and at the exposure of the sensor; then measure again, or remove those points"]
        )  # fmt: skip
    return dataset, count, corrupted


def clean(dataset: Dataset, settings: EstimationSettings = DEFAULTS) -> Cleaned:
    """Return a dataset without gross errors.

    Raises:
        TooManyStrayPoints: More than ``most_set_aside`` of the scans have so many stray points that they show no line.
        Undetermined: So many poses contradict each other that it cannot be decided which are right.
    """
    dataset, n_points, corrupted = without_stray_points(dataset, settings.gross_errors)
    keep = ~corrupted
    keep &= coarsely_consistent(dataset, keep, settings.gross_errors)
    keep &= not_turned(dataset, keep, settings.gross_errors)
    try:
        keep = _agreeing(dataset, keep, settings)
    except InvalidInput as error:
        # The guesses of the planes may be wrong, or the labels: the data alone cannot say which.
        raise Undetermined(
            [
                *(str(fault) for fault in error.faults),
                "correct the labels or the initial guesses of the planes first: until they agree, nothing can be said of what the model lacks",
            ]
        ) from None
    off = [int(i) for i in np.flatnonzero(~keep)]
    refuse_lost_session(dataset, keep)
    if len(off) > settings.gross_errors.most_set_aside * dataset.n_poses:
        raise Undetermined(
            [f"{len(off)} of {dataset.n_poses} poses contradict the rest: no part of the data can be trusted over another; "
             f"check {'the plane labels in poses.csv, ' if dataset.planes else ''}the nominal robot and the units"]
        )  # fmt: skip
    labels = other_labels(dataset, keep, off, settings)
    ids = dataset.pose_ids
    return Cleaned(
        dataset.subset(keep) if len(off) else dataset,
        tuple(int(ids[i]) for i in off if i not in labels),
        tuple((int(ids[i]), labels[i]) for i in off if i in labels),
        n_points,
    )


def _agreeing(dataset: Dataset, keep: Array, settings: EstimationSettings) -> Array:
    """Return ``finely_consistent``; where that fit fails and no nominal pose is stated, wrong labels may have led it astray and are looked for.

    With a nominal pose, the poses were judged by it before. Without one, all poses take part in the first guess of the sensor's place.

    Raises:
        InvalidInput: The guesses of the planes are contradicted even without the poses that disagree with the others.
        Undetermined: The data cannot determine the model.
    """
    found, failure = keep, None
    try:
        found, distance = finely_consistent(dataset, keep, settings)
        if not found.any() or distance[found].max() < settings.sufficiency.gross_error:
            return found
    except (InvalidInput, Undetermined) as error:
        failure = error
    again = None
    if dataset.planes and dataset.sensor.T_flange_sensor is None:
        again = _consistent_without_labels(dataset, keep, settings)
    if again is not None:
        return again
    if failure is not None:
        raise failure
    return found


def _consistent_without_labels(dataset: Dataset, keep: Array, settings: EstimationSettings) -> Array | None:
    """Return which poses agree with a calibration that starts from poses whose labels agree; None if there is no such start, or all agree with it."""
    posed = with_estimated_pose(dataset, keep, settings.gross_errors)
    if posed is None:
        return None
    agreeing = coarsely_consistent(posed, keep, settings.gross_errors)
    if np.array_equal(agreeing, keep):
        return None
    try:
        return finely_consistent(dataset, agreeing, settings)[0]
    except (InvalidInput, Undetermined):
        return None


def clean_given_effects(
    cleaned: Cleaned,
    distance: Array,
    brief: Array | None = None,
    settings: GrossErrorSettings = DEFAULTS.gross_errors,
) -> Cleaned:
    """Return the cleaned dataset without poses that prove to be gross errors once effects are modelled; the same object if there are none.

    As long as the model lacks an effect (an arm that sags, a plane that moved), all residuals are enlarged, and a gross error may hide among
    them. If more than ``settings.most_late`` of the poses stand out (``most_apart`` if no other pose comes near them, and in any case more than
    one), the effects are not trusted yet, and no pose is set aside. Poses whose neighbours stand out as well are no gross errors: something that
    the model still lacks acts there. Nor are poses that stand out by less than ``outlier_limit`` if more poses lie half-way to the limit than
    beyond it: they are the tail of one law, and a gross error stands apart.

    Args:
        cleaned: As ``clean`` returned it.
        distance: ``(N,)`` [m], root mean square distance of every pose that remains, effects applied.
        brief: ``(N,)`` bool, the poses between two changes that the effects have within a few poses; None if there are none.
        settings: Thresholds.

    Raises:
        Undetermined: No pose of a session of a tracker would remain.
    """
    dataset = cleaned.dataset
    limit = max(settings.least_late_error, settings.late_sigmas * robust_std(distance))
    off = distance >= limit
    half_way = np.count_nonzero((distance >= limit / 2) & ~off)
    # The tail of one law, as of poses that are read before the arm stands.
    if half_way > np.count_nonzero(off) + 1:
        off = distance >= outlier_limit(distance, settings)
    off &= ~in_runs(dataset, off, settings)
    off &= ~_among_similar(dataset, distance, off, settings)
    brief = np.zeros_like(off) if brief is None else brief
    most = (settings.most_apart if half_way == 0 else settings.most_late) * dataset.n_poses
    if np.count_nonzero(off & ~brief) > max(most, 1.0):
        return cleaned
    off |= brief
    if not off.any():
        return cleaned
    refuse_lost_session(dataset, ~off)
    late = tuple(int(pose) for pose in dataset.pose_ids[off])
    return replace(cleaned, dataset=dataset.subset(~off), outlier_poses=cleaned.outlier_poses + late)


def _among_similar(dataset: Dataset, distance: Array, off: Array, settings: GrossErrorSettings) -> Array:
    """Return which of the poses that are off ``(N,)`` bool have neighbours that are off as well, along a joint or in the order of acquisition."""
    found = np.zeros_like(off)
    coordinates = [*dataset.q.T, order_and_time(dataset)[0]]
    usual = settings.similar_ratio * float(np.median(distance))
    for i in np.flatnonzero(off):
        for x in coordinates:
            apart = np.abs(x - x[i])
            apart[i] = np.inf
            nearest = np.argsort(apart, kind="stable")[: settings.similar_poses]
            found[i] |= float(np.median(distance[nearest])) > usual
    return found
