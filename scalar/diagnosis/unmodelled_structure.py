"""Find structure that is significant but that no named effect explains, and describe it by flexible terms.

A flexible term describes a shape and names no cause. It has to pass stricter tests than a named effect. It replaces a named effect, all named effects
of a joint, or all changes in time, if it explains the data far better than these. For example, a scale error and five harmonics together imitate a
step of a joint's angle, although the joint has none of them. Such structure is reported as unattributed, never under the name of the nearest effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.background import Background
from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.candidate_set import flexible
from scalar.diagnosis.conditional_scores import background_without, score_together
from scalar.diagnosis.dropped_effects import without_effects_of_same_curve, without_minor_effects
from scalar.diagnosis.evidence_of_states import evidence_of
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.forward_selection import reconsidered, select_forward
from scalar.diagnosis.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.merging import merged
from scalar.diagnosis.ranking import Scored, rank, refined
from scalar.effects import Effect

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

COLUMNS_AT_ONCE = 512  # of flexible terms that are computed together
# Largest growth of the held-out error in metres with which a flexible term replaces named effects. Weighted rows may hide that it predicts
# other poses worse: on a measured arm the error at poses held out grew threefold.
MOST_GROWTH = 1.2


def flexible_candidate_sets(dataset: Dataset) -> list[CandidateSet]:
    """Return all flexible terms of a dataset as candidate sets that are small enough for the memory (``_in_parts``)."""
    return _in_parts(flexible(dataset))


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
            trial = _with_replacement(state, named, pools) or _with_best(state, pools)
            if trial is None:
                break
            state = without_effects_of_same_curve(select_forward(reconsidered(trial, named)[0], named))
        complete, state = state, reconsidered(state, named)[0]
        # An effect that proved to be unneeded may have hidden a term, which is looked for once more.
        if len(state.effects) >= len(complete.effects):
            break
    return without_minor_effects(without_effects_of_same_curve(state))


def _in_parts(pool: Sequence[Effect]) -> list[CandidateSet]:
    """Return the candidate sets of consecutive parts of a pool of terms.

    The columns of all terms at once would take too much memory, and no products of columns of different terms are needed.
    """
    parts: list[list[Effect]] = [[]]
    width = 0
    for candidate in pool:
        width += len(candidate.coefficients)
        if width > COLUMNS_AT_ONCE:
            parts.append([])
            width = len(candidate.coefficients)
        parts[-1].append(candidate)
    return [CandidateSet.of(part, elsewhere=len(pool) - len(part)) for part in parts]


def _ranked(
    state: FittedState, backgrounds: Sequence[Background], pools: Sequence[CandidateSet]
) -> list[list[Scored]]:
    """Return for each background the few flexible terms of all pools with the most evidence, best first."""
    most = state.settings.flexible_terms.most_terms_tried
    found: list[list[Scored]] = [[] for _ in backgrounds]
    for pool in pools:
        columns = CandidateColumns.of(state, pool)
        for entries, background in zip(found, backgrounds, strict=True):
            entries += rank(state, background, columns, most)
    return [sorted(entries, key=lambda entry: -entry.evidence)[:most] for entries in found]


def ranked_once(
    state: FittedState, backgrounds: Sequence[Background], pools: Sequence[CandidateSet]
) -> list[list[Scored]]:
    """Return what ``_ranked`` does for pools that live as long as the state, each background ranked only once."""
    keys = {background: ("flexible terms", background, *pools) for background in backgrounds}
    missing = [background for background, key in keys.items() if key not in state.results]
    if missing:
        ranked = _ranked(state, missing, pools)
        state.results.update(
            (keys[background], entries) for background, entries in zip(missing, ranked, strict=True)
        )
    return [state.results[keys[background]] for background in backgrounds]


def evidence_without_a_name(state: FittedState, pools: Sequence[CandidateSet]) -> list[list[float]]:
    """Return for each effect the log evidence of the flexible terms that would explain most in its place [nats].

    Two amounts are subtracted: the margin by which a flexible term has to surpass a named effect, and half the logarithm of the degrees of
    freedom for the order or place that was refined. Without the second, a wave of arbitrary order would score as high as a true harmonic. Nothing is
    subtracted for terms that are as likely beforehand and as specific as the effect (``Effect.imitators_are_as_likely``).

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
            found[i] += [entry.evidence for entry in imitators]
    return found


def imitating(state: FittedState, background: Background, named: Effect) -> list[Scored]:
    """Return the few flexible terms with the most evidence that may imitate a named effect (``Effect.imitators``), best first; they may be none."""

    def ranked() -> list[Scored]:
        return _ranked(state, [background], _in_parts(named.imitators(state.dataset)))[0]

    return state.once(("imitating", background, named), ranked)


def refined_once(state: FittedState, background: Background, entry: Scored) -> Scored:
    """Return what ``refined`` does for an entry of a ranking that is kept by the state."""
    return state.once(("refined", background, entry), lambda: refined(state, background, entry))


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


def _with_replacement(
    state: FittedState, named: CandidateSet, pools: Sequence[CandidateSet]
) -> FittedState | None:
    """Return the state in which one or several flexible terms replace a group of named effects that explains far less than they do, or None."""
    replaceable, settings = list(groups(state.effects)), state.settings.flexible_terms
    if not replaceable:
        return None
    left_out = [background_without(state, indices) for indices in replaceable]
    # The state's own background as well, which is asked for next if nothing is replaced: the columns are then there.
    *ranked, _ = ranked_once(state, [*(without for without, _, _ in left_out), state.background()], pools)
    for indices, left, entries in zip(replaceable, left_out, ranked, strict=True):
        without, own = left[0], score_together(state, indices, pools[0], left)
        imitated = next(
            (state.effects[i] for i in indices if state.effects[i].imitators(state.dataset)), None
        )
        if imitated is not None:
            entries = sorted([*entries, *imitating(state, without, imitated)], key=lambda e: -e.evidence)
        others = tuple(e for k, e in enumerate(state.effects) if k not in indices)
        # Several terms together are tried only with the best term as the first of them, because each attempt refits everything several times. They
        # are not tried in place of a spectrum of many orders.
        together_from = None
        if (
            imitated is not None
            and imitated.partial_imitators(state.dataset)
            and own.dof <= settings.most_coefficients_imitated
        ):
            together_from = max(entries, key=lambda entry: entry.evidence, default=None)
        for entry in entries:
            # If the named effect has more coefficients, further flexible terms may join the first one, which then has to explain only its share.
            shapes = 1 + settings.most_further_shapes if entry is together_from and own.dof > entry.dof else 1
            if entry.evidence < settings.least_share_to_refine * own.evidence / shapes:
                continue
            best = refined_once(state, without, entry)
            trial = state.refitted(merged(others, best.effect))
            better = best.evidence - own.evidence
            if entry is together_from and imitated is not None and better <= settings.replacement_margin:
                several, evidence = _with_partial_imitators(trial, imitated)
                if evidence - own.evidence > better:
                    trial, better = several, evidence - own.evidence
            least_gain = settings.replacement_margin
            if better <= settings.replacement_margin and best.effect.of_instrument and better > 0:
                # A strong error within profiles hardly shows in scores whose variance it has itself raised: the refitted models decide.
                least_gain = state.settings.selection.overwhelming_evidence
            elif better <= settings.replacement_margin:
                continue
            # A model with fewer coefficients may fit a little worse, but it must not predict worse; one that contains the named effect as a special
            # case fits better in any case, and has to predict better.
            now, then = (held_out_errors(each, state.whitening) for each in (state, trial))
            least = state.settings.selection.least_improvement
            contains = best.effect.contains_imitated
            predicts_worse = (
                improvement(now, then) < least if contains else improvement(then, now) >= least
            ) or held_out_errors(trial).rms > MOST_GROWTH * held_out_errors(state).rms
            if predicts_worse or not trial.is_plausible:
                continue
            # The scores above compare only the terms that are exchanged, linearised at the model with the named effects. After the refit, the whole
            # model has to explain the data better by the same margin.
            gain = _evidence_of(trial, named, pools) - _evidence_of(state, named, pools)
            if gain > least_gain:
                return trial
    return None


def _evidence_of(state: FittedState, named: CandidateSet, pools: Sequence[CandidateSet]) -> float:
    """Return the log evidence of a state [nats] as ``evidence_of`` does, with two further penalties for each flexible term.

    They are for the larger number of candidates, and for the refined order or place (half the logarithm of the degrees of freedom).
    """
    n_flexible = sum(effect.flexible for effect in state.effects)
    penalty = np.log(pools[0].total / named.total) + 0.5 * np.log(
        state.background_within_scans().degrees_of_freedom
    )
    return evidence_of(state, named) - n_flexible * float(penalty)


def _with_partial_imitators(state: FittedState, imitated: Effect) -> tuple[FittedState, float]:
    """Return a state with further flexible terms that together may imitate a named effect, and the log evidence of all these terms [nats].

    The last effect of ``state`` is the first of the terms. With each further term all of them are refined again, each given the others, because waves
    of different orders look alike over a short range of angles.
    """
    pools = _in_parts(imitated.partial_imitators(state.dataset))
    first = len(state.effects) - 1
    best, evidence = state, -np.inf
    for _ in range(state.settings.flexible_terms.most_further_shapes):
        background = state.background()
        more = refined(state, background, _ranked(state, [background], pools)[0][0])
        if more.evidence <= 0:
            break
        state = _refined_again(state.refitted((*state.effects, more.effect)), first, pools[0])
        terms = list(range(first, len(state.effects)))
        now = score_together(state, terms, pools[0], background_without(state, terms)).evidence
        if now > evidence:
            best, evidence = state, now
    return best, evidence


def _refined_again(state: FittedState, first: int, pool: CandidateSet) -> FittedState:
    """Return a state whose effects from index ``first`` on are refined in turn, each given all others, until none changes."""
    for _ in range(state.settings.selection.refinement_rounds):
        changed = False
        for i in range(first, len(state.effects)):
            left_out = background_without(state, [i])
            own = score_together(state, [i], pool, left_out)
            effect = refined(state, left_out[0], own).effect
            if effect.key != state.effects[i].key:
                state = state.refitted((*state.effects[:i], effect, *state.effects[i + 1 :]))
                changed = True
        if not changed:
            break
    return state


def groups(effects: Sequence[Effect]) -> Iterator[list[int]]:
    """Yield the groups of effects that one term could replace, as indices: all of a joint, all that change in time or with a record, each alone."""
    by_joint: dict[int, list[int]] = {}
    in_time = []
    for i, effect in enumerate(effects):
        if effect.erring_joint is not None:
            by_joint.setdefault(effect.erring_joint, []).append(i)
        if effect.is_change_in_time or effect.follows:
            in_time.append(i)
    yield from (indices for indices in [*by_joint.values(), in_time] if len(indices) > 1)
    yield from ([i] for i, effect in enumerate(effects) if not effect.flexible)
