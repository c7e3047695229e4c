"""Explain a dataset in one run: clean it, select effects, and calibrate without effects, with them, and as shipped.

The same run is made on all poses, and on those of every part of the outer split.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.candidate_columns import CandidateSet, named_candidates
from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.diagnosis.forward_selection import select_forward
from scalar.diagnosis.harmonic_spectrum import as_whitened, with_spectrum
from scalar.diagnosis.joint_selection import select_jointly
from scalar.diagnosis.measured_rows import rows_given_own_noise
from scalar.diagnosis.near_data_sheet import near_data_sheet
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.shipped_fit import BY_COMPONENT, ShippedFit
from scalar.diagnosis.unmodelled_structure import flexible_pools, with_flexible_terms
from scalar.diagnosis.variance_components import VarianceComponent, WhitenedMeasurement, whitening_for
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned, clean, clean_given_effects
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.least_squares import Fit
from scalar.estimation.prepare import Prepared
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.estimation.result import Calibration
from scalar.estimation.setup.ran_away import ran_away
from scalar.estimation.setup.refusal import misfit_refused, refuse_wrong_setup
from scalar.estimation.setup.suspicion import MOST_LEFT


@dataclass(frozen=True, eq=False)
class Explained:
    """A cleaned dataset and the effects that explain it.

    Attributes:
        cleaned: The dataset without its gross errors.
        prepared: The same, prepared for fits.
        before, after: States without effects and with all that were found, without the priors of the data sheet, whose weight depends on the misfit.
        candidates: The candidate set of named effects.
        flexible_candidates: The candidate sets of flexible terms.
    """

    cleaned: Cleaned
    prepared: Prepared
    before: FittedState
    after: FittedState
    candidates: CandidateSet
    flexible_candidates: Sequence[CandidateSet] = ()

    def near_data_sheet(self) -> Explained:
        """Return the same with the priors of a calibration, for the final fits.

        Effects and random errors are judged without these priors. A large misfit gives them much weight, and the errors of the geometry that they
        then leave look like an effect, or like a random error of the poses.
        """
        return replace(self, before=near_data_sheet(self.before), after=near_data_sheet(self.after))

    def calibrated(
        self, shipped: ShippedFit, component: VarianceComponent | None
    ) -> tuple[Calibration, Calibration, Calibration]:
        """Return the calibrations without effects, with all that were found, and as shipped, with the weights of the fit that is shipped.

        Args:
            shipped: The fit that is shipped.
            component: The variance component by which its poses may be weighted.
        """
        weights = component if shipped.effects_fit == BY_COMPONENT else None
        before, found = self._concluded(self.before, None), self._concluded(self.after, weights)
        if shipped.without_effects:
            return before, found, before
        if shipped.choice.as_found:
            return before, found, found
        return before, found, self._concluded(shipped.choice.state, weights)

    def _concluded(self, state: FittedState, component: VarianceComponent | None) -> Calibration:
        settings = self.after.settings.estimation.fit
        return conclude(self.cleaned.dataset, self.prepared, *_final_fit(state, component), settings=settings)


def explained(dataset: Dataset, settings: Settings, progress: Callable[[str], None]) -> Explained:
    """Return the cleaned dataset with the effects that explain it.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.
    """
    progress("cleaning")
    cleaned = _cleaned(dataset, settings)
    named = _with_named_effects(dataset, cleaned, settings, progress)
    for _ in range(settings.selection.max_cleanings):
        cleaned_again = clean_given_effects(
            cleaned, named.after.residuals.pose_distances(named.after.model), settings.estimation.gross_errors
        )
        if cleaned_again is cleaned:
            break
        cleaned = cleaned_again
        named = _with_named_effects(dataset, cleaned, settings, progress)
    progress("looking for unmodelled structure")
    pools = flexible_pools(named.after.dataset)
    after = with_flexible_terms(named.after, named.candidates, pools)
    progress("fitting joints that need many orders")
    after = with_spectrum(after, named.candidates)
    return replace(named, after=after, flexible_candidates=pools)


def _cleaned(dataset: Dataset, settings: Settings) -> Cleaned:
    """Return the dataset without gross errors, or refuse it if its set-up is described wrongly.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
        Undetermined: The poses contradict one another, and no corrected description explains them.
    """
    try:
        return clean(dataset, settings.estimation)
    except (InvalidInput, Undetermined):
        refuse_wrong_setup(dataset)
        raise


def _refuse_misfit(dataset: Dataset, state: FittedState) -> None:
    """Refuse data whose residual is larger than any effect can make it, or whose fit describes another arm.

    Raises:
        InvalidInput: A corrected description of the set-up explains the data.
        Undetermined: No corrected description explains them.
    """
    distances = state.residuals.pose_distances(state.model)
    typical = float(np.median(distances))
    if typical > MOST_LEFT or ran_away(state.model):
        refuse_wrong_setup(dataset)
    if typical > state.settings.estimation.sufficiency.gross_error:
        raise misfit_refused(state.dataset, distances)


def _with_named_effects(
    dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: Callable[[str], None]
) -> Explained:
    """Return a cleaned dataset with the named effects that are selected on it."""
    model, prepared = geometry_fit(cleaned.dataset, settings.estimation, effects_follow=True)
    rows = rows_given_own_noise(cleaned.dataset, model, settings.estimation.within_scan_noise)
    before = refit(cleaned.dataset, model, prepared.free, (), settings, rows)
    _refuse_misfit(dataset, before)
    candidates = named_candidates(cleaned.dataset)
    progress("selecting effects")
    after = select_jointly(before, select_forward(before, candidates), candidates)
    # Noise that is estimated from a residual comes out too large if the model lacks effects. With the effects that were found, the weights are
    # estimated again, and the selection is repeated.
    reweighted = rows.reweighted(after.residuals, after.model)
    if reweighted is not None:
        before = refit(cleaned.dataset, model, prepared.free, (), settings, reweighted)
        after = select_jointly(before, select_forward(before, candidates), candidates)
    return Explained(cleaned, prepared, before, after, candidates)


def _final_fit(state: FittedState, component: VarianceComponent | None) -> tuple[Fit, Residuals]:
    """Return the final fit of a state.

    It is made on all points, except in three cases, in which it is made on profile rows: the poses are weighted by a variance component, the rows
    are weighted for noise that was estimated within the scans, or an effect acts on single points. A scan has hundreds of points, so if the
    assumed form of such an effect is slightly wrong, the shape within the scans outweighs the poses and shifts the lengths of the arm. Profile
    rows, on which the effect was selected, avoid this.

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
    return fit_from(state.dataset, as_whitened(state).model, state.free, residuals, settings)
