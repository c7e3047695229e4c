"""Calibrate: from a dataset to robot, sensor, target and effects with their standard errors.

The one objective is the squared whitened residual of ``scalar.estimation.residuals``; robot, sensor, target and effects are fitted together.
The parameters that the data do not determine are derived for the robot and the poses at hand (``scalar.estimation.identifiability``)
and fixed; there is no list of parameters that are always fixed.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.errors import Fault, InvalidInput, NotConverged, Undetermined
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned, TooManyStrayPoints, clean, without_stray_points
from scalar.estimation.joint_fit import fit_all
from scalar.estimation.measured_effects import measured_effects, with_target_motion
from scalar.estimation.misfit import lacks_something
from scalar.estimation.model import Model
from scalar.estimation.motion import refuse_without_motion
from scalar.estimation.pose_consistency import distances_under
from scalar.estimation.prepare import prepare
from scalar.estimation.result import Calibration
from scalar.estimation.settings import DEFAULTS, EstimationSettings, GrossErrorSettings
from scalar.estimation.setup.explain import MOST_LEFT
from scalar.estimation.setup.orientations import refuse_wrong_orientations
from scalar.estimation.setup.planes.known_planes import KnownPlaneContradicted, refuse_contradicted_planes
from scalar.estimation.setup.refusal import misfit_refused, refuse_wrong_setup
from scalar.estimation.setup.sensor.exchanged_names import names_exchanged_in_words
from scalar.estimation.setup.sessions.unstated_session import unstated_session
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.setup.tables.placeholders import refuse_placeholders
from scalar.estimation.setup.tables.repeated_reading import reading_repeated
from scalar.estimation.setup.tables.wrongly_logged import wrongly_logged
from scalar.estimation.sufficiency import FitFailed, TooManyUnknowns
from scalar.estimation.suspected_setup import with_plainer_reading, with_suspicions
from scalar.estimation.turned_orientations import refuse_turned
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

_BY_CHANCE = 1e-5  # chosen: 3 of 1.6 million points with normal noise lie off the line of their scan, since the scale of each scan is estimated


def calibrate(
    dataset: Dataset,
    *,
    effects: Sequence[Effect] = (),
    fixed_effects: Sequence[Effect] = (),
    fix: Sequence[str] = (),
    settings: EstimationSettings = DEFAULTS,
    explain: bool = True,
) -> Calibration:
    """Return the calibration of a dataset: robot, sensor, target and effects at once.

    Args:
        dataset: What was measured.
        effects: Effects to estimate; the fit starts from their coefficients.
        fixed_effects: Effects to apply with their coefficients as they are. Effects that the dataset itself measures (by references on the base)
            are fixed as well.
        fix: Names of further parameters to fix at their nominal values.
        settings: Thresholds.
        explain: Whether a refusal names the cause: wrong signs, zeros, units or labels, or single poses. The search takes seconds; a Monte
            Carlo study that only counts refusals can leave it out.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine the model, the fit did not converge, or stray points hide the lines of too many scans.

    Example:
        >>> from scalar import calibrate, read_dataset
        >>> calibration = calibrate(read_dataset("my-cell"))
        >>> calibration.residual_rms < 1e-3  # m
        True
    """
    refuse_without_motion(dataset)
    dataset = with_target_motion(dataset)
    set_up_tried = False  # whether other readings of the set-up were tried, which takes seconds
    if explain:
        refuse_placeholders(dataset)
        refuse_wrong_orientations(dataset)
        refuse_turned(dataset, settings.gross_errors)
    fixed_effects = (*fixed_effects, *measured_effects(dataset, (*effects, *fixed_effects)))
    try:
        prepared = prepare(
            dataset,
            fix,
            settings,
            effects_follow=bool(effects or fixed_effects),
        )
        found, residuals = fit_all(dataset, prepared, effects, fixed_effects, settings)
        distances = residuals.pose_distances(found.model)
        if explain and np.median(distances) > MOST_LEFT:
            set_up_tried = True
            refuse_wrong_setup(dataset)
        refuse_contradicted_planes(dataset, found.model)
        if distances.max() > settings.sufficiency.gross_error:
            if explain:
                _refuse_gross_errors(dataset, settings)
            raise misfit_refused(dataset, distances, settings)
        calibration = conclude(dataset, prepared, found, residuals, settings.fit)
        if explain:
            (calibration,) = with_plainer_reading(dataset, [calibration])
        return _with_stray_points_reported(calibration, dataset, settings.gross_errors)
    except (TooManyStrayPoints, TooManyUnknowns, KnownPlaneContradicted):
        raise
    except (InvalidInput, Undetermined) as error:
        if explain:
            _explain(error, dataset, settings, set_up_tried=set_up_tried)
        raise


def _with_stray_points_reported(
    calibration: Calibration, dataset: Dataset, settings: GrossErrorSettings
) -> Calibration:
    """Return the calibration with a suspicion added to its summary if points lie off the line of their own scan, else the same object.

    The points are examined only if the noise does not explain the residual. A calibration uses all points, and in least squares a single
    stray point can change the optimum without bound.

    Raises:
        TooManyStrayPoints: More than ``most_set_aside`` of the scans have so many stray points that they show no line.
    """
    summary = calibration.summary
    if summary["misfit_p_value"] is not None and not lacks_something(summary):
        return calibration
    _, count, corrupted = without_stray_points(dataset, settings)
    if count <= _BY_CHANCE * len(dataset.points) and not corrupted.any():
        return calibration
    most = f"in {corrupted.sum()} of the scans most points" if corrupted.any() else ""
    some = f"{count} points" if count else ""
    which = " and ".join(filter(None, (some, most)))
    suspicion = Suspicion(
        "points",
        dataset.sensor.kind,
        f"{which} lie off the line of their own scan; this calibration uses them, and may err because of them: let 'scalar diagnose' "
        "set them aside, or remove them",
    )
    return with_suspicions(calibration, [suspicion])


def _explain(
    error: InvalidInput | Undetermined, dataset: Dataset, settings: EstimationSettings, *, set_up_tried: bool
) -> None:
    """Refuse a dataset with the cause of an error; do nothing if no cause is found.

    Args:
        error: What the calibration raised.
        dataset: The dataset.
        settings: Thresholds.
        set_up_tried: Whether no other reading of the set-up explained the data already, so that none is tried again.

    Raises:
        InvalidInput: Its set-up is described wrongly, or single poses contradict the rest.
        Undetermined: So many poses contradict each other that none can be trusted.
    """
    guess_contradicted = isinstance(error, FitFailed) or (
        isinstance(error, InvalidInput)
        and any((fault.column or "").startswith("planes.") for fault in error.faults)
    )
    if not set_up_tried and (isinstance(error, Undetermined) or guess_contradicted):
        refuse_wrong_setup(dataset)
    if isinstance(error, NotConverged):
        _refuse_gross_errors(dataset, settings)
    if guess_contradicted:  # a few poses with a wrong label can turn the planes of all
        with suppress(Undetermined):
            _refuse_gross_errors(dataset, settings)


def _refuse_gross_errors(dataset: Dataset, settings: EstimationSettings) -> None:
    """Refuse a dataset with poses that contradict the rest, naming them; do nothing if the rest does not agree either, so that none can be blamed.

    Raises:
        InvalidInput: Poses lie on another plane than poses.csv states, or on none.
        Undetermined: So many poses contradict each other that none can be trusted.
    """
    cleaned = clean(dataset, settings)
    rows = {int(pose): row for row, pose in enumerate(dataset.pose_ids)}
    set_aside = bool(cleaned.outlier_poses or cleaned.mislabelled_poses)
    away = _fit_to_the_others(dataset, cleaned, settings) if set_aside else None
    found = unstated_session(dataset, cleaned.outlier_poses)
    if found is None and away is not None and away.typical > MOST_LEFT:
        return
    logged = [] if away is None else wrongly_logged(dataset, cleaned.outlier_poses, away.model)
    if logged:
        raise InvalidInput([Fault("poses.csv", one.sentence, None, "pose") for one in logged])
    faults = [
        Fault(
            "poses.csv",
            f"pose {pose} is said to lie on '{dataset.poses['plane'].iloc[rows[pose]]}' and lies on '{plane}': correct its plane"
            f"{_angles_of_another(dataset, rows[pose])}",
            None,
            "plane",
        )
        for pose, plane in cleaned.mislabelled_poses
    ]
    alone = cleaned.outlier_poses
    if found is not None:
        suspicion, moved = found
        faults.append(Fault("poses.csv", suspicion.sentence, None, "session"))
        alone = tuple(pose for pose in alone if not moved[rows[pose]])
    if away is not None:
        far = np.isin(dataset.pose_ids, alone)
        explained, sentences = names_exchanged_in_words(dataset, away.model, far, away.distances)
        measured = kind_of(dataset).format.measured_in
        faults += [Fault(measured, sentence, None, "target") for sentence in sentences]
        alone = tuple(pose for pose in alone if not explained[rows[pose]])
    for pose in alone:
        how_far = ""
        if away is not None:
            how_far = (
                f": it lies {away.distances[rows[pose]] / MM:.3g} mm from where a fit to the others has it, and these "
                f"lie {away.typical / MM:.2g} mm from it in the median"
            )
        message = (
            f"pose {pose} contradicts all others{how_far}{reading_repeated(dataset, rows[pose])}; remove it, or let "
            "'scalar diagnose' set it aside"
        )
        faults.append(Fault("poses.csv", message, None, "pose"))
    if faults:
        raise InvalidInput(faults)


def _angles_of_another(dataset: Dataset, row: int) -> str:
    """Return the end of a sentence on a pose that has the joint angles of another one, which may have been written twice; empty for most poses."""
    same = np.all(dataset.q == dataset.q[row], axis=1)
    same[row] = False
    return (
        f", or its joint angles, which are those of pose {dataset.pose_ids[np.argmax(same)]}"
        if same.any()
        else ""
    )


class _FitToOthers(NamedTuple):
    """A fit to the poses that were not set aside: the distance of every pose from it ``(N,)`` [m], the median of those fitted [m], and the model."""

    distances: Array
    typical: float
    model: Model


def _fit_to_the_others(
    dataset: Dataset, cleaned: Cleaned, settings: EstimationSettings
) -> _FitToOthers | None:
    """Return the fit to the poses that were not set aside, with the distances of all poses from it; None if it fails."""
    with suppress(InvalidInput, Undetermined):
        model = geometry_fit(cleaned.dataset, settings)[0]
        distances = distances_under(dataset, model)
        of_others = distances[np.isin(dataset.pose_ids, cleaned.dataset.pose_ids)]
        return _FitToOthers(distances, float(np.median(of_others)), model)
    return None
