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
from scalar.diagnosis.joint_selection import select_together
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
        before, after: States without effects and with all that were found, without priors of the data sheet that the misfit weighs.
        tried: The candidate set of named effects.
        flexible: Those of the flexible terms.
    """

    cleaned: Cleaned
    prepared: Prepared
    before: FittedState
    after: FittedState
    tried: CandidateSet
    flexible: Sequence[CandidateSet] = ()

    def near_data_sheet(self) -> Explained:
        """Return the same with the priors of a calibration, for the final fits.

        Whatever is judged is judged without these: a misfit makes them tight, and what they then hold in the geometry looks like an effect, or
        like poses that do not repeat.
        """
        return replace(self, before=near_data_sheet(self.before), after=near_data_sheet(self.after))

    def calibrated(
        self, shipped: ShippedFit, component: VarianceComponent | None
    ) -> tuple[Calibration, Calibration, Calibration]:
        """Return the calibrations without effects, with all that were found, and as shipped, with the weights of the fit that is shipped.

        Args:
            shipped: What is shipped.
            component: Whose weights it may have.
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
    start = _selected(dataset, cleaned, settings, progress)
    for _ in range(settings.selection.max_cleanings):
        cleaner = clean_given_effects(
            cleaned, start.after.residuals.pose_distances(start.after.model), settings.estimation.gross_errors
        )
        if cleaner is cleaned:
            break
        cleaned = cleaner
        start = _selected(dataset, cleaned, settings, progress)
    progress("looking for unmodelled structure")
    pools = flexible_pools(start.after.dataset)
    after = with_flexible_terms(start.after, start.tried, pools)
    progress("fitting joints that need many orders")
    after = with_spectrum(after, start.tried)
    return replace(start, after=after, flexible=pools)


def _cleaned(dataset: Dataset, settings: Settings) -> Cleaned:
    """Return the dataset without gross errors, or refuse its set-up if that is why the poses contradict one another.

    Raises:
        InvalidInput: One other reading of the set-up explains the data.
        Undetermined: The poses contradict one another, and no other reading of the set-up explains them.
    """
    try:
        return clean(dataset, settings.estimation)
    except (InvalidInput, Undetermined):
        refuse_wrong_setup(dataset)
        raise


def _refuse_misfit(dataset: Dataset, state: FittedState) -> None:
    """Refuse data whose residual is larger than any effect can make it, or whose fit describes another arm.

    Raises:
        InvalidInput: One other reading of the set-up explains the data.
        Undetermined: No other reading of the set-up explains the data.
    """
    distances = state.residuals.pose_distances(state.model)
    typical = float(np.median(distances))
    if typical > MOST_LEFT or ran_away(state.model):
        refuse_wrong_setup(dataset)
    if typical > state.settings.estimation.sufficiency.gross_error:
        raise misfit_refused(state.dataset, distances)


def _selected(
    dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: Callable[[str], None]
) -> Explained:
    """Return the effects that are selected on a dataset once it is cleaned."""
    model, prepared = geometry_fit(cleaned.dataset, settings.estimation, effects_follow=True)
    rows = rows_given_own_noise(cleaned.dataset, model, settings.estimation.within_scan_noise)
    before = refit(cleaned.dataset, model, prepared.free, (), settings, rows)
    _refuse_misfit(dataset, before)
    tried = named_candidates(cleaned.dataset)
    progress("selecting effects")
    found = select_together(before, select_forward(before, tried), tried)
    # What a model lacks enlarges a noise that is estimated from its residual, so the weights are estimated anew with what was found.
    again = rows.reweighted(found.residuals, found.model)
    if again is not None:
        before = refit(cleaned.dataset, model, prepared.free, (), settings, again)
        found = select_together(before, select_forward(before, tried), tried)
    return Explained(cleaned, prepared, before, found, tried)


def _final_fit(state: FittedState, component: VarianceComponent | None) -> tuple[Fit, Residuals]:
    """Return the final fit of a state: on all points, or on profile rows where these are weighted for their noise or an effect acts on single points.

    Of an effect that acts on single points the shape within the scans tells most, hundreds of points a scan. A shape that is slightly wrong there
    decides against the poses, and moves the lengths of the arm; profile rows, on which the effect was selected and judged, do not show it.

    Args:
        state: To fit.
        component: Variance component of whole poses by which the rows are weighted, or None.
    """
    residuals, settings = state.residuals, state.settings.estimation
    if component is None:
        white = state.rows.noise is None and not extra_basis_of(state.effects)
        own = None if white else residuals
        return fit_from(state.dataset, state.model, state.free, own, settings)
    residuals = type(residuals)(
        WhitenedMeasurement(residuals.measurement, whitening_for(component), component.as_noise()),
        residuals.poses,
        residuals.bases,
        residuals.known,
    )
    return fit_from(state.dataset, as_whitened(state).model, state.free, residuals, settings)
