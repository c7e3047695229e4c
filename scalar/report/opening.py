"""The two sentences with which the report begins: what matters most, and what to do first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.effects.picture import Map, Profile
from scalar.effects.title import joints_in_words
from scalar.estimation.misfit import lacks_something
from scalar.report import words
from scalar.report.excess_words import (
    SCATTER_OF_WHAT,
    cause_of_excess,
    more_than_instrument,
    unexplained_excess,
)
from scalar.report.few_poses import few_poses
from scalar.report.further_poses import answer_on
from scalar.report.noise_card import SURE, noise_advice, noise_clause, noise_size

if TYPE_CHECKING:
    from scalar.diagnosis.naming.finding import Finding
    from scalar.diagnosis.result import Diagnosis
    from scalar.effects import Effect

_CLAUSES = 3  # clauses on effects in the first sentence; further kinds of effects are counted

EVEN = 0.5  # confidence up to which a name is wrong at least as often as right

Pictures = Sequence[Profile | Map]


def opening(diagnosis: Diagnosis, mapping: Mapping[str, Any], pictures: Sequence[Pictures]) -> list[str]:
    """Return two sentences: what matters most, and what to do first.

    Args:
        diagnosis: The diagnosis to report.
        mapping: Its ``to_mapping()``.
        pictures: The pictures of each finding, in the order of the findings; a finding without an entry has no size in the sentence.
    """
    return [_what_matters(diagnosis, mapping, pictures), _what_to_do(diagnosis)]


def by_importance(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in descending order of how far each lowered the squared held-out error when it was added."""
    return sorted(findings, key=lambda finding: finding.after.rms**2 - finding.before.rms**2)


def clauses(findings: Sequence[Finding], pictures: Sequence[Pictures]) -> list[str]:
    """Return one clause with a size for each kind of finding, the most important kind first; structure without a certain name comes last.

    An effect whose confidence is below ``SURE`` is stated as what the cause may be, with its rivals.
    """
    drawn = {id(finding): shown for finding, shown in zip(findings, pictures, strict=False)}
    together: dict[tuple[str, bool], list[Finding]] = {}
    for finding in by_importance([finding for finding in findings if not finding.doubtful]):
        kind = finding.effect.reported_with or finding.effect.name
        together.setdefault((kind, _is_unsure(finding)), []).append(finding)
    named = []
    for (_, unsure), alike in together.items():
        clause = alike[0].effect.clause_of([finding.effect for finding in alike])
        size = _largest(alike, [drawn.get(id(finding), ()) for finding in alike])
        named.append(_as_unsure(clause, size, alike) if unsure else _with_size(clause, size))
    doubtful = [finding for finding in by_importance(findings) if finding.doubtful]
    return named + ([_without_a_name(doubtful)] if doubtful else [])


UNSURE = "found that the model lacks something, and not surely what"
"""The verdict on a diagnosis in which ``nothing_sure``."""
MORE = "found something that the model lacks; the residual holds more"
"""The verdict where the residual clearly exceeds the noise with everything that was found."""
IN_PART = "found something that the model lacks; not every name is sure"
"""The verdict where some names are sure and others are not."""
FOUND = "found what the model lacks"


def verdict_on_effects(diagnosis: Diagnosis) -> str:
    """Return the verdict on a diagnosis that has found effects."""
    if nothing_sure(diagnosis):
        return UNSURE
    if unexplained_excess(diagnosis):
        return MORE
    return IN_PART if any(_is_unsure(finding) for finding in diagnosis.findings) else FOUND


def verdict_on_structure(diagnosis: Diagnosis) -> str:
    """Return the verdict on a diagnosis that is ``unattributed``: whether the structure resembles an effect whose name is not certain, or none."""
    if any(finding.doubtful for finding in diagnosis.findings):
        return "structure without a certain name"
    return "structure that no known effect explains"


def nothing_sure(diagnosis: Diagnosis) -> bool:
    """Return whether something was found, and no name of it is sure."""
    return bool(diagnosis.findings) and all(_is_unsure(finding) for finding in diagnosis.findings)


def _is_unsure(finding: Finding) -> bool:
    """Return whether a name is given with so little confidence that the first sentence must not state it as a fact."""
    return finding.confidence < SURE and not finding.effect.flexible


def _as_unsure(clause: str, size: str, findings: Sequence[Finding]) -> str:
    """Return a clause on effects whose names are not sure, with the names of the rivals that the data do not distinguish from them."""
    rivals = dict.fromkeys(words.quoted(rival.title) for f in findings for rival in f.confounded_with)
    likely = not rivals and min(finding.confidence for finding in findings) > EVEN
    said = _with_size(f"{'probably' if likely else 'perhaps'} {clause}", size)
    return (
        f"{said}, which these data do not distinguish from {words.listed(list(rivals), 'or')}"
        if rivals
        else said
    )


def _without_a_name(findings: Sequence[Finding]) -> str:
    """Return the clause on structure that resembles effects; those of one kind at several joints are said together, without their orders."""
    alike: dict[str, list[Effect]] = {}
    for finding in findings:
        effect = finding.effect
        alike.setdefault(effect.kind if effect.erring_joint else effect.title, []).append(effect)
    most_like = [
        words.quoted(effects[0].title)
        if len({effect.title for effect in effects}) == 1
        else f"{words.quoted(kind)} of {joints_in_words(sorted({e.erring_joint or 0 for e in effects}))}"
        for kind, effects in alike.items()
    ]
    return f"there is structure to which these data give no certain name; it resembles {words.listed(most_like, 'or')}"


def _largest(findings: Sequence[Finding], pictures: Sequence[Pictures]) -> str:
    """Return the size of the largest of several effects; empty if none has a picture."""
    if len(findings) == 1:
        return findings[0].effect.size(pictures[0])
    largest = max(findings, key=lambda finding: float(np.abs(finding.effect.coefficients).max(initial=0.0)))
    shown = [picture for drawn in pictures for picture in drawn]
    alike = [
        picture
        for picture in shown
        if type(picture) is type(shown[0]) and picture.y_axis.unit == shown[0].y_axis.unit
    ]
    size = largest.effect.size(alike)
    states_coefficient = bool(size) and size == largest.effect.size([])  # a kind without pictures
    return f"up to {size}" if states_coefficient else size


def _with_size(clause: str, size: str) -> str:
    return f"{clause} ({size})" if size else clause


def _what_matters(diagnosis: Diagnosis, mapping: Mapping[str, Any], pictures: Sequence[Pictures]) -> str:
    """Return the sentence on what was found, with the held-out errors before and after."""
    before, after = (
        words.number(mapping["residual"][when]["held_out_rms_mm"]) for when in ("before", "after")
    )
    level = f"noise alone would leave {words.number(mapping['residual']['floor_mm'])} mm"
    error = "the error on poses held out from the fit"
    found = clauses(diagnosis.findings, pictures)
    has_noise = bool(diagnosis.reported_noise)
    noise = [_with_size(noise_clause(diagnosis), noise_size(diagnosis))] if has_noise else []
    if not found and not noise and lacks_something(diagnosis.calibration_after.summary):
        times = f"{diagnosis.calibration_after.summary['misfit']:.1f}"
        return f"The residual is {times} times what the noise explains, because of {cause_of_excess(diagnosis)}: {error} is {before} mm, and {level}."
    if not found and not noise and (beyond := more_than_instrument(diagnosis)):
        return (
            f"No effect was found, but {beyond}: {error} is {before} mm, and a scatter like that of these measurements would leave "
            f"{words.number(mapping['residual']['floor_mm'])} mm."
        )
    if not found and not noise:
        return f"These data show nothing that the model lacks: {error} is {before} mm, and {level}."
    said = _joined(found, noise)
    if not found or diagnosis.shipped.without_effects:
        return f"{said}: {error} is {after} mm, and {level}."
    held_out = mapping["residual"]
    change = (
        "falls" if held_out["after"]["held_out_rms_mm"] < held_out["before"]["held_out_rms_mm"] else "changes"
    )
    if after == before:
        change, values = "stays at", f"{after} mm"
    else:
        values = f"from {before} to {after} mm"
    what = "this" if len(diagnosis.findings) + len(noise) == 1 else "these"
    return f"{said}: with {what} in the model, {error} {change} {values}, and {level}."


def _joined(found: Sequence[str], noise: Sequence[str]) -> str:
    """Return clauses as the beginning of a sentence, separated by semicolons; clauses beyond the first few are counted."""
    more = len(found) - _CLAUSES
    counted = (
        [f"there {'is' if more == 1 else 'are'} {more} further kind{'' if more == 1 else 's'} of effects"]
        if more > 0
        else []
    )
    shown = [*found[:_CLAUSES], *counted, *noise]
    if len(shown) < 3:
        return words.capital(", and ".join(shown))
    return words.capital("; ".join(shown[:-1]) + "; and " + shown[-1])


def _what_to_do(diagnosis: Diagnosis) -> str:
    """Return the sentence on what to do first."""
    if not diagnosis.findings:
        if too_few := few_poses(diagnosis):
            return too_few[0]
        if not diagnosis.reported_noise and lacks_something(diagnosis.calibration_after.summary):
            return (
                "Use after.json with care, since it may err by more at other poses; check the noise that dataset.yaml states, and measure more "
                "poses: they show what the model lacks."
            )
        if not diagnosis.reported_noise and more_than_instrument(diagnosis):
            return SCATTER_OF_WHAT
        return (
            noise_advice(diagnosis)[0]
            if diagnosis.reported_noise
            else "Use the calibration after.json as it is: nothing asks for a repair."
        )
    lead = by_importance(diagnosis.findings)[0]
    if warning := caution(diagnosis, lead):
        return warning
    return (
        lead.effect.advice[0]
        if lead.effect.advice
        else "Use after.json, which takes this effect into account."
    )


def caution(diagnosis: Diagnosis, finding: Finding) -> str:
    """Return what to do before a finding is acted on, if its cause is confounded with another or not certain; else nothing."""
    if finding.effect.flexible:
        return ""
    percent = words.confident(finding.confidence)
    if finding.doubtful:
        how_sure = (
            f"its name has a confidence of {percent}, and no more because {finding.limit}"
            if finding.limit
            else f"a name with such evidence has been right in {percent} of the simulated trials"
        )
        return f"Look for the cause before anything is repaired: {words.quoted(finding.effect.title)} is only what it resembles most, and {how_sure}."
    if finding.confounded_with:
        return _distinguish(diagnosis, finding)
    if finding.confidence >= SURE:
        return ""
    why = (
        f"because {finding.limit}"
        if finding.limit
        else "which is how often a name with such evidence was right in simulated trials"
    )
    return (
        f"Confirm {words.quoted(finding.effect.title)} with a second campaign before anything is repaired: its confidence is only {percent}, "
        f"{why}."
    )


def _distinguish(diagnosis: Diagnosis, lead: Finding) -> str:
    """Return what to do if two causes are confounded: measure poses that distinguish them or, if no poses would, look for the cause."""
    answer = answer_on(diagnosis, lead)
    unclear = f"these data do not distinguish {words.quoted(lead.effect.title)} from {words.quoted(lead.confounded_with[0].title)}"
    if answer is None:
        return f"Before anything is repaired, measure more poses: {unclear}."
    if not answer.separable:
        return f"Before anything is repaired, look for the cause at the arm itself: {unclear}, and no further poses would."
    return f"Before anything is repaired, measure the poses that 'scalar plan FOLDER --after diagnosis.json' chooses: {unclear}."
