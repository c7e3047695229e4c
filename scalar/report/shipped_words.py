"""Sentences of the report on the fit that is shipped, that is, written as after.json: its weights, its effects, and where it should be used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.diagnosis.shipping.nested_models import LIMITS
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT
from scalar.report.beyond_ranges import beyond_ranges
from scalar.report.lead_in import FITS_DISAGREE, REGIONS, WITHOUT_EFFECTS
from scalar.report.narrow_ranges import narrow_ranges
from scalar.report.words import length, listed, number, quoted
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis
    from scalar.diagnosis.shipping.focused_choice import FocusedChoice


def shipped_sentences(diagnosis: Diagnosis) -> list[str]:
    """Return sentences on how the fit in ``after.json`` was chosen, if it is not simply the fit with all findings, and where it is right."""
    return [
        *_without_effects(diagnosis),
        *_left_out(diagnosis),
        *_added(diagnosis),
        *_unconfirmed(diagnosis),
        *_weights(diagnosis),
        *_in_other_regions(diagnosis),
        *beyond_ranges(diagnosis),
        *narrow_ranges(diagnosis.cleaned.dataset),
    ]


def _left_out(diagnosis: Diagnosis) -> list[str]:
    choice = diagnosis.shipped.choice
    if not choice.left_out or diagnosis.shipped.without_effects:
        return []
    names = listed([quoted(effect.title) for effect in choice.left_out])
    them = "it" if len(choice.left_out) == 1 else "them"
    return [
        f"after.json does not correct for {names}, because these data do not determine {them} well enough: predictions at other poses are "
        f"expected to err by {length(choice.error_with_all)} with this correction, and by {length(choice.errors_as_chosen[LIMITS])} without "
        f"it{_although_smaller(choice)}."
    ]


def _although_smaller(choice: FocusedChoice) -> str:
    """Return why effects are left out with which the expected error is smaller; nothing if it is larger."""
    if choice.error_with_all >= choice.errors_as_chosen[LIMITS]:
        return ""
    return ": a correction that gains so little, or whose cause has no sure name, may do harm"


def _added(diagnosis: Diagnosis) -> list[str]:
    choice = diagnosis.shipped.choice
    if not choice.added or diagnosis.shipped.without_effects:
        return []
    names = listed([quoted(effect.title) for effect in choice.added])
    a_finding = "a finding" if len(choice.added) == 1 else "findings"
    return [
        f"after.json also corrects for {names}. The data do not show this clearly enough to report it as {a_finding}, but with this correction "
        "predictions at other poses are expected to be nearer to the truth."
    ]


def _unconfirmed(diagnosis: Diagnosis) -> list[str]:
    effects = diagnosis.shipped.unconfirmed
    if not effects:
        return []
    names, are = listed([quoted(effect.title) for effect in effects]), "is" if len(effects) == 1 else "are"
    return [
        f"after.json also corrects for {names}, which {are} not confirmed: without this correction, held-out poses and regions are predicted worse. "
        "Part of what it corrects is real, but it may have another cause."
    ]


def _in_other_regions(diagnosis: Diagnosis) -> list[str]:
    shipped = diagnosis.shipped
    if shipped.without_effects or shipped.regions is None:
        return []
    without, effects = (number(error.rms / MM) for error in shipped.regions)
    count = int(shipped.regions[0].block.max()) + 1
    return [
        f"{REGIONS.format(count=count)}, its poses are predicted to {effects} mm RMS with the effects, "
        f"and to {without} mm without. Expect such errors, in which the noise of the measurement is included, next to the poses that were measured; "
        "farther away they may be larger."
    ]


def _without_effects(diagnosis: Diagnosis) -> list[str]:
    shipped = diagnosis.shipped
    if not shipped.without_effects:
        return []
    if shipped.decided_by == "expected_error":
        choice = shipped.choice
        with_all, without = length(choice.error_with_all), length(choice.errors_as_chosen[LIMITS])
        return [
            f"{WITHOUT_EFFECTS}, because with them predictions at other poses are expected to err by {with_all}, "
            f"and by {without} without them{_although_smaller(choice)}. The effects are findings only, and nothing is corrected for them."
        ]
    if shipped.decided_by == "undetermined_geometry":
        return [
            f"{WITHOUT_EFFECTS}, because these poses leave a part of the geometry to the data sheet. Effects may then "
            "stand for errors of the geometry: among the measured poses they reduce the residual, and elsewhere they may do harm. They are findings "
            "only, and nothing is corrected for them. Poses that differ in all joints would determine the geometry ('scalar plan' chooses them)."
        ]
    if shipped.decided_by == "extrapolation":
        expected, errs = length(shipped.choice.errors_as_chosen[LIMITS]), length(shipped.held_out.rms)
        return [
            f"{WITHOUT_EFFECTS}, because with them predictions over the whole of the joint limits are expected to err by "
            f"{expected}, far more than the model without them errs at held-out poses ({errs} RMS): the measured poses do not show how the "
            "correction extrapolates. The effects are findings only, and nothing is corrected for them. Measure poses all over the workspace "
            "('scalar plan' chooses them), and diagnose again."
        ]
    if shipped.decided_by == "few_poses":
        return [
            f"{WITHOUT_EFFECTS}, because unmodelled structure was found in few poses. In simulated trials, correcting "
            "for it did harm as often as good. Measure more poses ('scalar plan' chooses them), and diagnose again."
        ]
    on_unseen = diagnosis.halves if diagnosis.outer is None else diagnosis.outer
    if shipped.decided_by == "unseen" and on_unseen is not None:
        poses = "poses that took no part in the diagnosis"
        without_and_with = [e.rms for e in on_unseen.errors]
    elif shipped.decided_by == "regions" and shipped.regions is not None:
        poses = "regions of the joint space that are held out as a whole"
        without_and_with = [e.rms for e in shipped.regions]
    else:
        poses = "poses held out from the fit"
        without_and_with = [shipped.held_out.rms, shipped.rms_with_equal_weights]
    without, with_effects = (number(rms / MM) for rms in without_and_with)
    return [
        f"{WITHOUT_EFFECTS}, because with them {poses} are predicted worse ({with_effects} mm RMS, "
        f"{without} mm without). The effects are findings only, and nothing is corrected for them."
    ]


def _weights(diagnosis: Diagnosis) -> list[str]:
    shipped = diagnosis.shipped
    found = shipped.disagreement
    if found is None or shipped.without_effects:
        return []
    weighted = shipped.fit == BY_COMPONENT
    equal_rms, weighted_rms = (f"{number(rms / MM, 4)} mm RMS" for rms in found.held_out_rms)
    equal_std, weighted_std = (length(std) for std in found.predicted_std)
    why = (
        f"{'the fits with and without these weights disagree, and ' if found.beyond_chance else ''}held-out poses are predicted clearly "
        "worse with them"
        if found.weights_mislead
        else f"these weights {'make' if weighted else 'would not make'} predictions at other poses clearly more certain"
    )
    figures = (
        f"when single poses are left out, predictions vary by {weighted_std} with the weights and by {equal_std} without; "
        f"held-out poses are predicted to {weighted_rms} with them, {equal_rms} without"
    )
    used = "the weights that the random error gives the poses" if weighted else "equal weights for all poses"
    sentences = [f"after.json is fitted with {used}: {why} ({figures})."]
    if found.beyond_chance:
        sentences.append(
            f"{FITS_DISAGREE}: the fits with and without these weights disagree. Their predictions differ by {length(found.difference)}, with a "
            f"standard error of {length(found.difference_std)}. A random error that is the same at all poses does not explain this, so something "
            "may act on some poses only. Look at the poses with the largest residuals before the correction is used."
        )
    return sentences
