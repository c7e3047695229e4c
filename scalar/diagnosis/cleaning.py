"""Set gross errors aside before and after effects are known, and refuse data that no effect can explain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.repetitions import distances_from_other_readings
from scalar.diagnosis.selection.brief_changes import between_brief_changes
from scalar.diagnosis.settings import Settings
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.gross_errors import Cleaned, TooManyStrayPoints, clean, clean_given_effects
from scalar.estimation.pose_consistency import refuse_lost_session
from scalar.estimation.ran_away import ran_away
from scalar.estimation.setup.explain import MOST_LEFT
from scalar.estimation.setup.planes.known_planes import refuse_contradicted_planes
from scalar.estimation.setup.refusal import misfit_refused, refuse_wrong_setup
from scalar.estimation.sufficiency import TooManyUnknowns

# Chosen, of the poses: if an effect cannot be computed at more of them, they are kept.
_MOST_UNKNOWN = 0.1
# Chosen: measurements of a pose are so many times as far from their median if one of them, which is wrong, shifts it.
_OF_SHIFTED = 2.0


def cleaned_given(cleaned: Cleaned, state: FittedState) -> Cleaned:
    """Return the cleaned dataset without the poses that prove to be gross errors given the effects of a state; the same object if there are none.

    Poses at which one of the effects cannot be computed are left out before that (``_with_known_moves``).

    Where poses were measured several times, each measurement is compared with the others of its pose as well: what the model lacks is in all of them,
    and hides no gross error of one.
    """
    known = _with_known_moves(cleaned, state)
    if known is not cleaned:
        return known
    settings = state.settings.estimation.gross_errors
    distances = state.residuals.pose_distances(state.model)
    again = clean_given_effects(cleaned, distances, between_brief_changes(state), settings)
    if again is not cleaned:
        return again
    from_others = distances_from_other_readings(state)
    if from_others is None:
        return cleaned
    # Similar poses are the others of the same pose, whose median the wrong one has shifted.
    return clean_given_effects(
        cleaned, from_others, None, replace(settings, similar_ratio=_OF_SHIFTED * settings.similar_ratio)
    )


def _with_known_moves(cleaned: Cleaned, state: FittedState) -> Cleaned:
    """Return the cleaned dataset without poses at which an effect of a state is left out, because the moves to them are not known.

    As a rule these are the first poses of a campaign or a session. A joint with play errs there as it does elsewhere, and the model cannot say in
    which direction: to a sensor that measures finely, such a pose looks like structure of its own. If they are more than a few, they are kept.
    """
    unknown = np.zeros(state.dataset.n_poses, dtype=bool)
    for effect in state.effects:
        unknown |= effect.moves_unknown(state.dataset.known_poses)
    if not unknown.any() or unknown.sum() > _MOST_UNKNOWN * len(unknown):
        return cleaned
    try:
        refuse_lost_session(cleaned.dataset, ~unknown)
    except Undetermined:
        return cleaned
    ids = tuple(int(pose) for pose in cleaned.dataset.pose_ids[unknown])
    return replace(
        cleaned,
        dataset=cleaned.dataset.subset(~unknown),
        direction_unknown=cleaned.direction_unknown + ids,
    )


def cleaned_or_refused(dataset: Dataset, settings: Settings) -> Cleaned:
    """Return the dataset without gross errors, or refuse it if its set-up is described wrongly.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
        Undetermined: Most scans have lost their line to stray points, or the poses contradict one another and no corrected description explains them.
    """
    try:
        return clean(dataset, settings.estimation)
    except (TooManyStrayPoints, TooManyUnknowns):
        raise
    except (InvalidInput, Undetermined):
        refuse_wrong_setup(dataset)
        raise


def refuse_misfit(dataset: Dataset, state: FittedState) -> None:
    """Refuse data if the residual of most poses is larger than any effect can make it, or the fitted geometry is far from the nominal arm.

    Args:
        dataset: As it was given, before cleaning.
        state: The fit of the cleaned dataset without effects.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
        Undetermined: No corrected description explains them.
    """
    distances = state.residuals.pose_distances(state.model)
    median_distance = float(np.median(distances))  # [m]
    if median_distance > MOST_LEFT or ran_away(state.model):
        refuse_wrong_setup(dataset)
    refuse_contradicted_planes(dataset, state.model)
    if median_distance > state.settings.estimation.sufficiency.gross_error:
        raise misfit_refused(state.dataset, distances, state.settings.estimation, diagnosed=True)


def without_far_poses(dataset: Dataset, cleaned: Cleaned, state: FittedState) -> Cleaned:
    """Return the cleaned dataset without a few poses whose residual is larger than any effect can make it; the same object if there are none.

    Cleaning sets a pose aside if its residual exceeds a multiple of the usual residual of the poses. Where the instrument scatters by millimetres,
    or its errors at neighbouring poses are correlated, a pose may be a centimetre off and is not set aside. It is a gross error nevertheless. As long
    as no more than ``most_apart`` of the poses are so far off (one in any case), the others are trusted.

    Args:
        dataset: As it was given, before cleaning.
        cleaned: The dataset to which the state was fitted, with what was set aside.
        state: The fit of the cleaned dataset with all that was found.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
    """
    settings = state.settings.estimation
    far = state.residuals.pose_distances(state.model) > settings.sufficiency.gross_error
    if not far.any() or far.sum() > max(settings.gross_errors.most_apart * len(far), 1.0):
        return cleaned
    refuse_wrong_setup(dataset)
    refuse_lost_session(cleaned.dataset, ~far)
    far_ids = tuple(int(pose) for pose in cleaned.dataset.pose_ids[far])
    return replace(
        cleaned, dataset=cleaned.dataset.subset(~far), outlier_poses=cleaned.outlier_poses + far_ids
    )


def refuse_gross_errors_left(dataset: Dataset, state: FittedState) -> None:
    """Refuse data if the residual of a pose is larger than any effect can make it although all that was found is in the model.

    Cleaning sets a pose aside if its residual exceeds a multiple of the usual residual of the poses. So many gross errors that they distort the fit
    also raise this limit, and then none is set aside. The residuals that remain are then larger than the error of any arm.

    Args:
        dataset: As it was given, before cleaning.
        state: The fit of the cleaned dataset with all that was found.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
        Undetermined: No corrected description explains them.
    """
    distances = state.residuals.pose_distances(state.model)
    if distances.max() > state.settings.estimation.sufficiency.gross_error:
        refuse_wrong_setup(dataset)
        raise misfit_refused(state.dataset, distances, state.settings.estimation, diagnosed=True)
