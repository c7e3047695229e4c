"""Find structure that is significant but that no named effect explains, and describe it by flexible terms.

A flexible term describes a shape and names no cause. It has to pass stricter tests than a named effect. It replaces a named effect, all named effects
of a joint, or all changes in time, if it explains the data far better than these. For example, a scale error and five harmonics together imitate a
step of a joint's angle, although the joint has none of them. Such structure is reported as unattributed, never under the name of the nearest effect.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import background_without
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import refined
from scalar.diagnosis.selection.forward_selection import reconsidered, select_forward
from scalar.diagnosis.structure.dropped_effects import without_effects_of_same_curve, without_minor_effects
from scalar.diagnosis.structure.ranked_terms import imitating, ranked_once, refined_once
from scalar.diagnosis.structure.replaced_names import with_replacement


def with_flexible_terms(
    state: FittedState, named: CandidateSet, pools: Sequence[CandidateSet]
) -> FittedState:
    """Return a state with flexible terms for what its named effects leave; the named effects are tested again given these terms.

    Args:
        state: Where forward selection among the names ended.
        named: The candidate set of named effects.
        pools: The candidate sets of the flexible terms.
    """
    if state.is_rounding:
        return state
    for _ in range(2):
        for _ in range(state.settings.flexible_terms.max_terms):
            trial = with_replacement(state, named, pools) or _with_best(state, pools)
            if trial is None:
                break
            state = without_effects_of_same_curve(select_forward(reconsidered(trial, named)[0], named))
        complete, state = state, reconsidered(state, named)[0]
        # An effect that proved to be unneeded may have hidden a term, which is looked for once more.
        if len(state.effects) >= len(complete.effects):
            break
    return without_minor_effects(without_effects_of_same_curve(state))


def _with_best(state: FittedState, pools: Sequence[CandidateSet]) -> FittedState | None:
    """Return the state with the best flexible term that is significant and confirmed by held-out poses, or None."""
    background = state.background()
    for entry in ranked_once(state, [background], pools)[0]:
        if entry.p_value > state.settings.selection.alpha_unnamed or entry.evidence <= 0:
            return None
        effect = refined(state, background, entry).effect
        trial = state.refitted(merged(state.effects, effect))
        gain = improvement(held_out_errors(state, state.whitening), held_out_errors(trial, state.whitening))
        if gain >= state.settings.selection.least_improvement and no_worse(
            held_out_errors(state), held_out_errors(trial)
        ):
            return trial
    return None


def evidence_without_a_name(state: FittedState, pools: Sequence[CandidateSet]) -> list[list[float]]:
    """Return for each effect the log evidence of the flexible terms that would explain most in its place [nats].

    Two amounts are subtracted: the margin by which a flexible term has to surpass a named effect, and half the logarithm of the degrees of freedom
    for the order or place that was refined. Without the second, a wave of arbitrary order would score as high as a true harmonic. Only the choice of
    the place is subtracted for terms that are as likely beforehand and as specific as the effect (``Effect.imitators_are_as_likely``).

    Args:
        state: The fitted state.
        pools: The candidate sets of the flexible terms.

    Returns:
        A list for each effect of the state; it is empty for a flexible term.
    """
    named = [i for i, effect in enumerate(state.effects) if not effect.flexible]
    backgrounds = [background_without(state, [i])[0] for i in named]
    found: list[list[float]] = [[] for _ in state.effects]
    ranked = ranked_once(state, backgrounds, pools)
    for i, background, entries in zip(named, backgrounds, ranked, strict=True):
        imitators = imitating(state, background, state.effects[i])
        entries = entries + imitators
        penalty = state.settings.flexible_terms.replacement_margin + 0.5 * float(
            np.log(background.degrees_of_freedom)
        )
        found[i] = [refined_once(state, background, entry).evidence - penalty for entry in entries]
        if state.effects[i].imitators_are_as_likely:
            # They act where the effect does, and where that is was chosen among all of its kind.
            of_kind = float(np.log(max(len(state.effects[i].candidates(state.dataset)), 1)))
            found[i] += [entry.evidence - of_kind for entry in imitators]
    return found
