"""Diagnose a dataset: set gross errors aside, select effects, look for unmodelled structure, and calibrate with what was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.autocorrelation import depends_on
from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet, named_candidates
from scalar.diagnosis.conditional_scores import rivals
from scalar.diagnosis.confidence import confidence
from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.diagnosis.forward_selection import select_forward
from scalar.diagnosis.harmonic_spectrum import as_whitened, has_all_orders, is_shrunk, with_spectrum
from scalar.diagnosis.hold_out import held_out_errors
from scalar.diagnosis.identified_components import identified_components
from scalar.diagnosis.measured_rows import rows_given_own_noise
from scalar.diagnosis.merging import merged
from scalar.diagnosis.observability import unobservable_effects
from scalar.diagnosis.ranking import rank
from scalar.diagnosis.result import Diagnosis, Finding
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.diagnosis.shipped_fit import BY_COMPONENT, shipped_fit
from scalar.diagnosis.unmodelled_structure import evidence_without_a_name, with_flexible_terms
from scalar.diagnosis.variance_components import WhitenedMeasurement
from scalar.effects import Effect
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned, clean, clean_given_effects
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.least_squares import Fit
from scalar.estimation.prepare import Prepared
from scalar.estimation.residuals import Residuals
from scalar.estimation.setup.refusal import misfit_refused, refuse_wrong_setup
from scalar.estimation.setup.suspicion import MOST_LEFT
from scalar.geometry.se3 import Array

MAX_RANKING = 25


def diagnose(
    dataset: Dataset,
    progress: Callable[[str], None] = lambda stage: None,
    settings: Settings = DEFAULTS,
) -> Diagnosis:
    """Return which effects the rigid model of a dataset lacks, and the calibrations without and with them.

    Args:
        dataset: What was measured.
        progress: Called with the name of each stage.
        settings: Thresholds.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.

    Example:
        >>> from scalar import diagnose, read_dataset
        >>> diagnosis = diagnose(read_dataset("my-cell"))
        >>> diagnosis.verdict, [finding.effect.name for finding in diagnosis.findings]
        ('effect', ['joint_scale'])
    """
    progress("cleaning")
    cleaned = _cleaned(dataset, settings)
    start = _selected(dataset, cleaned, settings, progress)
    for _ in range(settings.selection.max_cleanings):
        cleaner = clean_given_effects(
            cleaned, start.found.residuals.pose_distances(start.found.model), settings.estimation.gross_errors
        )
        if cleaner is cleaned:
            break
        cleaned = cleaner
        start = _selected(dataset, cleaned, settings, progress)
    prepared, before, tried = start.prepared, start.before, start.tried
    ranking = rank(before, before.background(), CandidateColumns(before, tried))
    progress("looking for unmodelled structure")
    after = with_flexible_terms(start.found, tried)
    progress("fitting joints that need many orders")
    after = with_spectrum(after, tried)
    noise = identified_components(after)
    findings = _findings(before, after, tried)
    shipped = shipped_fit(before, after, after.whitening)
    progress("calibrating")
    fits = settings.estimation.fit
    calibration_before = conclude(
        cleaned.dataset,
        prepared,
        *_final_fit(before, None),
        settings=fits,
    )
    whitening = after.whitening if shipped.effects_fit == BY_COMPONENT else None
    calibration_found = conclude(cleaned.dataset, prepared, *_final_fit(after, whitening), settings=fits)
    # The findings report exactly the coefficients that the calibration contains.
    fitted = zip(findings, calibration_found.model.effects, calibration_found.effect_std, strict=True)
    findings = tuple(replace(f, effect=effect, std=tuple(std)) for f, effect, std in fitted)
    return Diagnosis(
        dataset=dataset,
        cleaned=cleaned,
        before=before,
        after=after,
        held_out_before=held_out_errors(before),
        calibration_before=calibration_before,
        calibration_found=calibration_found,
        shipped=shipped,
        findings=findings,
        noise=noise,
        depends_on=tuple(depends_on(after)) if noise else (),
        unobservable=tuple(unobservable_effects(after, [candidate for candidate, _ in tried.tried])),
        ranking=tuple(ranking[:MAX_RANKING]),
    )


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
    """Refuse data whose residual is larger than any effect can make it.

    Raises:
        InvalidInput: One other reading of the set-up explains the data.
        Undetermined: No other reading of the set-up explains the data.
    """
    distances = state.residuals.pose_distances(state.model)
    typical = float(np.median(distances))
    if typical > MOST_LEFT:
        refuse_wrong_setup(dataset)
    if typical > state.settings.estimation.sufficiency.gross_error:
        raise misfit_refused(state.dataset, distances)


@dataclass(frozen=True, eq=False)
class _Selected:
    """The selection on a cleaned dataset: its preparation, the states without effects and with the selected ones, and the candidate set."""

    prepared: Prepared
    before: FittedState
    found: FittedState
    tried: CandidateSet


def _selected(
    dataset: Dataset, cleaned: Cleaned, settings: Settings, progress: Callable[[str], None]
) -> _Selected:
    """Return the effects that are selected on a dataset once it is cleaned."""
    model, prepared = geometry_fit(cleaned.dataset, settings.estimation)
    rows = rows_given_own_noise(cleaned.dataset, model, settings.estimation.within_scan_noise)
    before = refit(cleaned.dataset, model, prepared.free, (), settings, rows)
    _refuse_misfit(dataset, before)
    tried = named_candidates(cleaned.dataset)
    progress("selecting effects")
    return _Selected(prepared, before, select_forward(before, tried), tried)


def _final_fit(state: FittedState, whitening: Array | None) -> tuple[Fit, Residuals]:
    """Return the final fit of a state: on all points where their noise is white, on profile rows where these are weighted for it.

    Args:
        state: To fit.
        whitening: Weights of a variance component of whole poses ``(N, m, m)``, or None.
    """
    residuals, fits = state.residuals, state.settings.estimation.fit
    if whitening is None:
        own = None if state.rows.noise is None else residuals
        return fit_from(state.dataset, state.model, state.free, own, fits)
    residuals = type(residuals)(
        WhitenedMeasurement(residuals.measurement, whitening, state.variance_components[0].as_noise()),
        residuals.poses,
        residuals.bases,
        residuals.known,
    )
    return fit_from(
        state.dataset, as_whitened(state).model, state.free, residuals, state.settings.estimation.fit
    )


def _findings(before: FittedState, after: FittedState, tried: CandidateSet) -> tuple[Finding, ...]:
    """Return the effects of a state one by one, each with the held-out error before and after it is added."""
    found: list[Finding] = []
    state, error = before, held_out_errors(before)
    effects: tuple[Effect, ...] = ()
    scored = as_whitened(after)
    columns = CandidateColumns(scored, tried)
    without_a_name = evidence_without_a_name(scored)
    for i, effect in enumerate(after.effects):
        effects = merged(effects, effect)
        state = after.refitted(effects, state.model)
        now = held_out_errors(state)
        own, ranking = rivals(scored, i, columns)
        ranking = [s for s in ranking if not has_all_orders(after, s.effect)]
        others = [s.evidence for s in ranking if not s.effect.same_answer(effect)] + without_a_name[i]
        near = [
            s.effect
            for s in ranking
            if s.evidence > own.evidence - after.settings.selection.confounded_margin
        ]
        near = [e for e in near if not e.same_place(effect) and not effect.flexible]
        if is_shrunk(effect):
            others, near = [], []
        sure = confidence(own.evidence, others, after.settings.confidence)
        found.append(Finding(effect, own.p_value, error, now, tuple(near), sure, ()))
        error = now
    return tuple(found)
