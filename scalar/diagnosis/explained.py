"""Explain a dataset in one run: clean it, select effects, and calibrate without effects, with them, and as shipped.

The diagnosis makes this run on all poses, and again without each part of the outer split, or on each half of the poses (``two_halves``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.beside_nuisances import explained_by_nuisances
from scalar.diagnosis.brief_changes import between_brief_changes
from scalar.diagnosis.candidate_columns import CandidateSet, named_candidates
from scalar.diagnosis.common_causes import with_common_causes
from scalar.diagnosis.evidence_of_states import evidence_of
from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.diagnosis.forward_selection import select_forward
from scalar.diagnosis.harmonic_spectrum import priors_for_whitened_rows, with_spectrum
from scalar.diagnosis.hold_out import held_out_errors, improvement
from scalar.diagnosis.instrument_errors import leads, with_error_of_instrument
from scalar.diagnosis.joint_selection import select_jointly
from scalar.diagnosis.measured_rows import rows_given_own_noise
from scalar.diagnosis.near_data_sheet import near_data_sheet
from scalar.diagnosis.ranked_terms import flexible_candidate_sets
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.shipped_fit import BY_COMPONENT, ShippedFit
from scalar.diagnosis.terms_of_loads import with_terms_of_loads
from scalar.diagnosis.unmodelled_structure import with_flexible_terms
from scalar.diagnosis.variance_components import JITTER, VarianceComponent, whitening_for
from scalar.diagnosis.whitened_measurement import WhitenedMeasurement
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned, TooManyStrayPoints, clean, clean_given_effects
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.least_squares import Fit
from scalar.estimation.prepare import Prepared
from scalar.estimation.ran_away import ran_away
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.estimation.result import Calibration
from scalar.estimation.setup.known_planes import refuse_contradicted_planes
from scalar.estimation.setup.refusal import misfit_refused, refuse_wrong_setup
from scalar.estimation.setup.suspicion import MOST_LEFT
from scalar.estimation.sufficiency import TooManyUnknowns


@dataclass(frozen=True, eq=False)
class Explained:
    """A cleaned dataset and the effects that explain it.

    Attributes:
        cleaned: The dataset without its gross errors, and what was set aside.
        prepared: The initial estimate and the free parameters of the cleaned dataset.
        before, after: Fitted states without effects and with all effects that were found. Both lack the priors of the data sheet
            (``near_data_sheet``).
        candidates: The candidate set of named effects.
        flexible_candidates: The candidate sets of flexible terms, which describe unmodelled structure without naming its cause; empty until they are
            tried.
        rival: The state with an error of the instrument that has the most log evidence (``with_error_of_instrument``); None if there is none.
    """

    cleaned: Cleaned
    prepared: Prepared
    before: FittedState
    after: FittedState
    candidates: CandidateSet
    flexible_candidates: Sequence[CandidateSet] = ()
    rival: FittedState | None = None

    def near_data_sheet(self) -> Explained:
        """Return a copy for the final fits: its states are fitted with the priors of the data sheet, as a calibration is.

        Effects and random errors are judged without these priors. A large misfit gives the priors much weight. They then keep the geometry from
        adapting, and the errors that remain look like an effect, or like a random error of the poses.
        """
        return replace(self, before=near_data_sheet(self.before), after=near_data_sheet(self.after))

    def calibrated(
        self, shipped: ShippedFit, component: VarianceComponent | None
    ) -> tuple[Calibration, Calibration, Calibration]:
        """Return the calibrations without effects, with all effects that were found, and as shipped.

        Args:
            shipped: The fit that is shipped.
            component: The likeliest variance component, or None. The fits with effects weight the poses by it if ``shipped.effects_fit`` says so.
        """
        weights = component if shipped.effects_fit == BY_COMPONENT else None
        before, found = self._concluded(self.before, None), self._concluded(self.after, weights)
        if shipped.without_effects:
            return before, found, before
        if shipped.choice.as_found:
            return before, found, found
        return before, found, self._concluded(shipped.choice.state, weights)

    def _concluded(self, state: FittedState, component: VarianceComponent | None) -> Calibration:
        """Return the calibration of the final fit of a state, its poses weighted by a variance component if there is one."""
        settings = self.after.settings.estimation.fit
        return conclude(self.cleaned.dataset, self.prepared, *_final_fit(state, component), settings=settings)


def explained(dataset: Dataset, settings: Settings, progress: Callable[[str], None]) -> Explained:
    """Return the cleaned dataset with the effects that explain it.

    Cleaning and selection are repeated at most ``settings.selection.max_cleanings`` times, because some gross errors show only with the effects in
    the model. Flexible terms and joints with many orders follow.

    Args:
        dataset: The dataset to diagnose.
        settings: Thresholds.
        progress: Called with the name of each stage.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.
    """
    progress("cleaning")
    cleaned = _cleaned(dataset, settings)
    cleanings = settings.selection.max_cleanings
    while True:
        named = _with_named_effects(dataset, cleaned, settings, progress)
        if cleanings and (again := _cleaned_given(cleaned, named.after)) is not cleaned:
            cleaned, cleanings = again, cleanings - 1
            continue
        progress("looking for unmodelled structure")
        flexible_candidates = flexible_candidate_sets(named.after.dataset)
        rival = with_error_of_instrument(named.before, named.after, named.candidates)
        leading = named.after if rival is None or not leads(rival, named.after, named.candidates) else rival
        after = with_flexible_terms(leading, named.candidates, flexible_candidates)
        progress("fitting joints that need many orders")
        after = with_spectrum(after, named.candidates)
        if not cleanings or (again := _cleaned_given(cleaned, after)) is cleaned:
            break
        cleaned, cleanings = again, cleanings - 1
    if not after.is_plausible:  # each step looks at its own change; this is the last look at all of them
        after = named.after if named.after.is_plausible else named.before
    _refuse_gross_errors_left(dataset, after)
    return replace(named, after=after, flexible_candidates=flexible_candidates, rival=rival)


def _cleaned_given(cleaned: Cleaned, state: FittedState) -> Cleaned:
    """Return the cleaned dataset without the poses that prove to be gross errors given the effects of a state; the same object if there are none."""
    return clean_given_effects(
        cleaned,
        state.residuals.pose_distances(state.model),
        between_brief_changes(state),
        state.settings.estimation.gross_errors,
    )


def _cleaned(dataset: Dataset, settings: Settings) -> Cleaned:
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


def _refuse_misfit(dataset: Dataset, state: FittedState) -> None:
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
        raise misfit_refused(state.dataset, distances, state.settings.estimation)


def _refuse_gross_errors_left(dataset: Dataset, state: FittedState) -> None:
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
        raise misfit_refused(state.dataset, distances, state.settings.estimation)


def _with_named_effects(
    dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: Callable[[str], None]
) -> Explained:
    """Return the cleaned dataset with the named effects that are selected on it.

    Args:
        dataset: As it was given; if the residual is too large, a corrected description of its set-up is looked for.
        cleaned: The same without gross errors.
        settings: Thresholds.
        progress: Called with the name of each stage.
    """
    model, prepared = geometry_fit(cleaned.dataset, settings.estimation, effects_follow=True)
    rows = rows_given_own_noise(cleaned.dataset, model, settings.estimation.within_scan_noise)
    before = refit(cleaned.dataset, model, prepared.free, (), settings, rows)
    _refuse_misfit(dataset, before)
    candidates = named_candidates(cleaned.dataset)
    progress("selecting effects")
    after = _selected(before, candidates)
    # Noise that is estimated from the residual of a model without the effects is too large. The weights are therefore estimated again with the
    # effects that were found, and the selection is repeated.
    reweighted = rows.reweighted(after.residuals, after.model)
    if reweighted is not None:
        before = refit(cleaned.dataset, model, prepared.free, (), settings, reweighted)
        after = _selected(before, candidates)
    return Explained(cleaned, prepared, before, after, candidates)


def _selected(before: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the named effects that are selected: one after the other, as a whole set, and those of common causes."""
    selected = select_jointly(before, select_forward(before, candidates), candidates)
    if _jitter_may_hide_effects(selected):
        equally = select_forward(before.with_equal_weights(), candidates)
        afresh = select_jointly(before, before.refitted(equally.effects, equally.model), candidates)
        if afresh.effects and _explains_more(afresh, selected, candidates):
            selected = afresh
    complete = with_common_causes(with_terms_of_loads(selected, candidates), candidates)
    return explained_by_nuisances(complete, candidates)


def _jitter_may_hide_effects(state: FittedState) -> bool:
    """Return whether the likeliest variance component of a state is a jitter larger than half of what the worst arms have.

    It may then stand for something that the model lacks. Poses that are weighted by it hide this: with several targets on the flange, a coupling of
    0.25 mm was taken for a jitter of 32 mrad, and nothing was found.
    """
    worst = state.settings.variance_components.worst_repeatability
    return any(c.name == JITTER and c.repeatability > worst / 2 for c in state.variance_components[:1])


def _explains_more(state: FittedState, other: FittedState, candidates: CandidateSet) -> bool:
    """Return whether a state has overwhelmingly more evidence than another, or clearly more and predicts held-out poses better."""
    settings = state.settings
    gain = evidence_of(state, candidates) - evidence_of(other, candidates)
    if gain > settings.selection.overwhelming_evidence:
        return True
    if gain <= settings.flexible_terms.replacement_margin:
        return False
    better = improvement(held_out_errors(other), held_out_errors(state))
    return better >= settings.selection.least_improvement


def _final_fit(state: FittedState, component: VarianceComponent | None) -> tuple[Fit, Residuals]:
    """Return the final fit of a state and the residuals that it minimised.

    The fit is made on all points, except in three cases, in which it is made on profile rows (a few numbers for each scan): the poses are weighted
    by a variance component, the rows are weighted for noise that was estimated within the scans, or an effect acts on single points. A scan has
    hundreds of points, so if the assumed form of such an effect is slightly wrong, the shape within the scans outweighs the poses and shifts the
    lengths of the arm. Profile rows, on which the effects were selected, avoid this.

    Args:
        state: The state to fit.
        component: Variance component of whole poses by which the rows are weighted, or None.
    """
    residuals, settings = state.residuals, state.settings.estimation
    if component is None:
        on_all_points = state.rows.noise is None and not extra_basis_of(state.effects)
        return fit_from(
            state.dataset, state.model, state.free, None if on_all_points else residuals, settings
        )
    residuals = type(residuals)(
        WhitenedMeasurement(residuals.measurement, whitening_for(component), component.as_noise()),
        residuals.poses,
        residuals.bases,
        residuals.known,
    )
    return fit_from(state.dataset, priors_for_whitened_rows(state).model, state.free, residuals, settings)
