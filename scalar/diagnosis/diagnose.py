"""Diagnose a dataset: select effects, confirm them on poses that took no part in the selection, and calibrate with the effects that were found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from scalar.data.dataset import Dataset
from scalar.diagnosis.explained import Explained, explained
from scalar.diagnosis.fit.near_data_sheet import near_data_sheet
from scalar.diagnosis.fit.variance_components import VarianceComponent, whitening_for
from scalar.diagnosis.held_out.hold_out import HeldOutErrors, held_out_errors
from scalar.diagnosis.held_out.outer_split import OuterSplit, outer_split
from scalar.diagnosis.held_out.repeated_runs import Answer
from scalar.diagnosis.held_out.repetitions import moving_joints
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.grounds import FinalResiduals, grounds_of_component
from scalar.diagnosis.naming.judged_effects import findings_of
from scalar.diagnosis.naming.limits_of_names import limited_names
from scalar.diagnosis.naming.observability import unobservable_effects
from scalar.diagnosis.naming.two_halves import two_halves
from scalar.diagnosis.naming.unstated_order import unstated_order
from scalar.diagnosis.noise.identified_components import identified_components, only_place
from scalar.diagnosis.result import Diagnosis
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns
from scalar.diagnosis.scoring.ranking import Scored, rank
from scalar.diagnosis.selection.joint_selection import settings_for_parts
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.diagnosis.shipping.shipped_fit import ShippedFit, shipped_fit, unconfirmed_effects_help
from scalar.effects.acquisition import numbered
from scalar.estimation.measured_effects import with_target_motion
from scalar.estimation.motion import refuse_without_motion
from scalar.estimation.result import Calibration
from scalar.estimation.setup.orientations import refuse_wrong_orientations
from scalar.estimation.setup.planes.other_side import other_side
from scalar.estimation.setup.sessions.session_boundary import boundaries_near_changes, misplaced_boundaries
from scalar.estimation.setup.sessions.unstated_session import run_set_aside, unstated_session
from scalar.estimation.setup.tables.wrongly_logged import wrongly_logged
from scalar.estimation.suspected_setup import with_plainer_reading, with_suspicions

MAX_RANKING = 25  # candidates that the ranking of a diagnosis lists


def diagnose(
    dataset: Dataset,
    progress: Callable[[str], None] = lambda stage: None,
    settings: Settings = DEFAULTS,
    outer_folds: int = 0,
    on_fold: Callable[[int, int], None] = lambda done, total: None,
    cores: int | None = None,
) -> Diagnosis:
    """Return which effects the rigid model of a dataset lacks, and the calibrations without and with them.

    Args:
        dataset: The dataset to diagnose.
        progress: Called with the name of each stage.
        settings: Thresholds.
        outer_folds: Number of parts of the outer split. The whole diagnosis is repeated without each part, and the errors on its poses are
            those on unseen poses. With zero, findings are not checked in this way, and these errors stay unknown. ``settings.hold_out.folds`` is the
            usual number. Whatever the number, the diagnosis is repeated on two halves of the poses if residuals of similar poses are correlated
            (``two_halves``).
        on_fold: Called before the first and after each of the runs of the outer split, with the number of runs that are done and the number of all.
        cores: Number of these runs at once; None for as many as there are processors that this process may use.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.

    Example:
        >>> from scalar import diagnose, read_dataset
        >>> diagnosis = diagnose(read_dataset("my-cell"))
        >>> diagnosis.verdict, [finding.effect.name for finding in diagnosis.findings]
        ('effect', ['joint_scale'])
    """
    refuse_without_motion(dataset)
    given = dataset
    dataset = numbered(with_target_motion(dataset))
    refuse_wrong_orientations(dataset)
    run = explained(dataset, settings, progress)
    final_residuals = FinalResiduals.of(run.after)
    found = findings_of(run, final_residuals)
    _forget_bases(run)
    moving, of_parts = moving_joints(run.before), settings_for_parts(settings, run.cleaned.dataset.n_poses)
    outer = outer_split(dataset, run.cleaned, answer_without, of_parts, outer_folds, on_fold, cores, moving)
    progress("comparing halves of the poses")
    halves = two_halves(dataset, run, answer_without, of_parts, cores)
    found = limited_names(found, run, halves, given)
    run, found, refused = _confirmed(run, found, outer)
    if refused:
        final_residuals = FinalResiduals.of(run.after)
    ranking = _ranking(run)
    noise = identified_components(run.after)
    progress("calibrating")
    judged = halves if outer is None else outer
    final, shipped, component = _shipped(
        run, noise, None if judged is None else judged.errors, _unsure(found, settings)
    )
    calibration_before, calibration_found, calibration_after = _with_suspicions_on_session_and_order(
        given, run, found, final.calibrated(shipped, component)
    )
    return Diagnosis(
        dataset=dataset,
        cleaned=run.cleaned,
        before=run.before,
        after=run.after,
        held_out_before=held_out_errors(final.before),
        calibration_before=calibration_before,
        calibration_found=calibration_found,
        calibration_after=calibration_after,
        shipped=shipped.with_unconfirmed([f.effect for f in refused]),
        findings=_with_calibrated_effects(found, calibration_found),
        not_confirmed=refused,
        noise=noise,
        noise_grounds=grounds_of_component(run.after, noise, final_residuals) if noise else None,
        depends_on=final_residuals.along if noise else (),
        noise_place=only_place(run.after, noise[0]) if noise else None,
        unobservable=tuple(
            unobservable_effects(
                run.after, [candidate for candidate, _ in run.candidates.tried], run.candidates.bases
            )
        ),
        ranking=ranking,
        outer=outer,
        halves=halves,
    )


def _forget_bases(run: Explained) -> None:
    """Forget the bases of a run: they take 280 MB at 12,000 poses, and the processes for halves would hold them as well."""
    for terms in run.flexible_candidates:
        terms.bases.forget()
    for state in (run.before, run.after):
        state.rows.fitted.forget()


def _ranking(run: Explained) -> tuple[Scored, ...]:
    """Return the candidates that explain most if they are added to the model without effects, best first."""
    columns = CandidateColumns.of(run.before, run.candidates)
    return tuple(rank(run.before, run.before.background(), columns, MAX_RANKING))


def _unsure(found: Sequence[Finding], settings: Settings) -> list[str]:
    """Return the keys of the effects whose names are doubtful."""
    least = settings.naming.least_confidence
    return [f.effect.key for f in found if not f.has_name or f.confidence < least]


def _with_suspicions_on_session_and_order(
    dataset: Dataset, run: Explained, found: Sequence[Finding], calibrations: Sequence[Calibration]
) -> list[Calibration]:
    """Return the calibrations, each with what is suspected of the sessions and of the order of the poses.

    A boundary between sessions may be stated at the wrong pose, or not at all, and the rows may not be in the order of acquisition. Where no session
    explains why successive poses were set aside, something else changed there, which is a suspicion too. If another sign or zero of a joint explains
    why the geometry is far from the table, this replaces the suspicion on the geometry (``with_plainer_reading``).

    Args:
        dataset: All that was measured.
        run: The run, with the poses that were set aside.
        found: The findings: a change that begins near a stated boundary is a suspicion.
        calibrations: The calibration without effects first.
    """
    set_aside = run.cleaned.outlier_poses
    suspicions = misplaced_boundaries(dataset, set_aside, calibrations[0].model) or wrongly_logged(
        dataset, set_aside, calibrations[0].model
    )
    # A boundary at the wrong pose explains what was set aside: the same poses are no session of their own.
    if not suspicions:
        unstated = unstated_session(dataset, set_aside)
        changed = run_set_aside(dataset, set_aside) if unstated is None else unstated[0]
        suspicions += [changed] if changed else []
    if not suspicions and (behind := other_side(dataset, set_aside, calibrations[0].model)):
        suspicions += [behind]
    effects = [finding.effect for finding in found]
    suspicions += [*boundaries_near_changes(dataset, effects), *unstated_order(dataset, effects)]
    read = with_plainer_reading(run.cleaned.dataset, calibrations)
    return [with_suspicions(calibration, suspicions) for calibration in read]


def _with_calibrated_effects(found: Sequence[Finding], calibration: Calibration) -> tuple[Finding, ...]:
    """Return the findings with the coefficients of the calibration with all effects that were found, and their standard errors.

    The unconfirmed effects of that calibration come after those of the findings.
    """
    n = len(found)
    fitted = zip(found, calibration.model.effects[:n], calibration.effect_std[:n], strict=True)
    return tuple(replace(f, effect=effect, std=tuple(std)) for f, effect, std in fitted)


def answer_without(dataset: Dataset, settings: Settings) -> Answer:
    """Return the answer of a whole diagnosis of some of the poses: a dataset without one part of the outer split, or one half of the poses."""
    run = explained(dataset, settings, lambda stage: None)
    noise = identified_components(run.after)
    final, shipped, component = _shipped(run, noise)
    before, _, after = final.calibrated(shipped, component)
    return Answer(
        before.model,
        after.model,
        run.after.effects,
        noise[0].name if noise else None,
    )


def _shipped(
    run: Explained,
    noise: Sequence[VarianceComponent],
    unseen: tuple[HeldOutErrors, HeldOutErrors] | None = None,
    unsure: Sequence[str] = (),
) -> tuple[Explained, ShippedFit, VarianceComponent | None]:
    """Return a run whose states have the priors of the final fits, which of these fits is shipped, and the component that may weight it.

    Args:
        run: The run whose states lack these priors.
        noise: Its variance components that were identified.
        unseen: Errors without and with effects on poses that no part of the diagnosis has used, or None.
        unsure: Keys of effects whose names are doubtful.
    """
    near = run.near_data_sheet()
    final = near if near.after.is_plausible else run
    component = run.after.variance_components[0] if noise else None
    whitening = None if component is None else whitening_for(component)
    determined = run.prepared.identifiability.n_left_to_priors == 0
    fit = shipped_fit(
        final.before, final.after, whitening, unseen, geometry_determined=determined, unsure=unsure
    )
    return final, fit, component


def _confirmed(
    run: Explained, found: tuple[Finding, ...], outer: OuterSplit | None
) -> tuple[Explained, tuple[Finding, ...], tuple[Finding, ...]]:
    """Return the run, refitted without the findings that are not confirmed, the confirmed findings, and those that are not confirmed.

    A finding is confirmed if at least the share ``settings.outer_split.least_selected`` of the runs of the outer split select its effect. Without an
    outer split, all findings count as confirmed. If predictions become worse without the others, the run keeps their effects, after those of the
    confirmed findings. Changes at a moment are not kept: whatever distinguishes the poses before from those after it seems to predict held-out poses
    of either part.
    """
    if outer is None or not outer.answers:
        return run, found, ()
    least = run.after.settings.outer_split.least_selected
    shares = [outer.selected_in(f.effect) for f in found]
    judged = [(replace(f, selected_in=share), share) for f, share in zip(found, shares, strict=True)]
    kept = tuple(f for f, share in judged if share >= least)
    refused = tuple(
        replace(f, confidence=min(f.confidence, share), std=(None,) * len(f.effect.coefficients))
        for f, share in judged
        if share < least
    )
    if refused:
        after = run.after.refitted([f.effect for f in kept])
        if not after.is_plausible:
            return run, found, ()
        lasting = [f for f in refused if "at" not in f.effect.target]
        if kept and lasting:
            everything = after.refitted([f.effect for f in (*kept, *lasting)])
            if unconfirmed_effects_help(near_data_sheet(after), near_data_sheet(everything)):
                after = everything
        run = replace(run, after=after)
    return run, kept, refused
