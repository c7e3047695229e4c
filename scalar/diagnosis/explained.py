"""Explain a dataset in one run: clean it, select effects, and calibrate without effects, with them, and as shipped.

The diagnosis makes this run on all poses, and again without each part of the outer split, or on each half of the poses (``two_halves``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from scalar.data.dataset import Dataset
from scalar.diagnosis.cleaning import (
    cleaned_given,
    cleaned_or_refused,
    refuse_gross_errors_left,
    refuse_misfit,
    without_far_poses,
)
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.fit.measured_rows import rows_given_own_noise
from scalar.diagnosis.fit.near_data_sheet import near_data_sheet
from scalar.diagnosis.fit.variance_components import VarianceComponent, whitening_for
from scalar.diagnosis.fit.whitened_measurement import WhitenedMeasurement
from scalar.diagnosis.scoring.candidate_columns import CandidateSet, named_candidates
from scalar.diagnosis.selection.harmonic_spectrum import priors_for_whitened_rows, with_spectrum
from scalar.diagnosis.selection.instrument_errors import leads, with_error_of_instrument
from scalar.diagnosis.selection.selected_effects import with_selected_effects
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT, ShippedFit
from scalar.diagnosis.structure.ranked_terms import flexible_candidate_sets
from scalar.diagnosis.structure.unmodelled_structure import with_flexible_terms
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.least_squares import Fit
from scalar.estimation.prepare import Prepared
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.estimation.result import Calibration

# Chosen: times that a few poses a centimetre off are set aside, each of which takes a whole run.
_FAR_ROUNDS = 2
_Progress = Callable[[str], None]


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


def explained(dataset: Dataset, settings: Settings, progress: _Progress) -> Explained:
    """Return the cleaned dataset with the effects that explain it.

    A few poses that are a centimetre off even then are set aside, and the rest is explained anew (``without_far_poses``).

    Args:
        dataset: The dataset to diagnose.
        settings: Thresholds.
        progress: Called with the name of each stage.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.
    """
    progress("cleaning")
    cleaned = cleaned_or_refused(dataset, settings)
    for _ in range(_FAR_ROUNDS):
        found = _explained_from(dataset, cleaned, settings, progress)
        cleaned = without_far_poses(dataset, found.cleaned, found.after)
        if cleaned is found.cleaned:
            break
    else:
        found = _explained_from(dataset, cleaned, settings, progress)
    refuse_gross_errors_left(dataset, found.after)
    return found


def _explained_from(dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: _Progress) -> Explained:
    """Return what explains a dataset, beginning with what a first cleaning left of it.

    Cleaning and selection are repeated at most ``settings.selection.max_cleanings`` times, because some gross errors show only with the effects in
    the model. Flexible terms and joints with many orders follow.

    Args:
        dataset: As it was given; if the residual is too large, a corrected description of its set-up is looked for.
        cleaned: The same after the first cleaning.
        settings: Thresholds.
        progress: Called with the name of each stage.
    """
    cleanings = settings.selection.max_cleanings
    while True:
        named = _with_named_effects(dataset, cleaned, settings, progress)
        if cleanings and (again := cleaned_given(cleaned, named.after)) is not cleaned:
            cleaned, cleanings = again, cleanings - 1
            continue
        progress("looking for unmodelled structure")
        flexible_candidates = flexible_candidate_sets(named.after.dataset)
        rival = with_error_of_instrument(named.before, named.after, named.candidates)
        leading = named.after if rival is None or not leads(rival, named.after, named.candidates) else rival
        after = with_flexible_terms(leading, named.candidates, flexible_candidates)
        progress("fitting joints that need many orders")
        after = with_spectrum(after, named.candidates)
        if not cleanings or (again := cleaned_given(cleaned, after)) is cleaned:
            break
        cleaned, cleanings = again, cleanings - 1
    if not after.is_plausible:  # each step checks its own change; this checks all of them together
        after = named.after if named.after.is_plausible else named.before
    return replace(named, after=after, flexible_candidates=flexible_candidates, rival=rival)


def _with_named_effects(
    dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: _Progress
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
    refuse_misfit(dataset, before)
    candidates = named_candidates(cleaned.dataset)
    progress("selecting effects")
    after = with_selected_effects(before, candidates)
    # Noise that is estimated from the residual of a model without the effects is too large. The weights are therefore estimated again with the
    # effects that were found, and the selection is repeated.
    reweighted = rows.reweighted(after.residuals, after.model)
    if reweighted is not None:
        before = refit(cleaned.dataset, model, prepared.free, (), settings, reweighted)
        after = with_selected_effects(before, candidates)
    return Explained(cleaned, prepared, before, after, candidates)


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
