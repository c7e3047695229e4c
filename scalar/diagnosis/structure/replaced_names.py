"""Replace named effects by flexible terms that explain the data far better.

A flexible term describes a shape and names no cause. It replaces a named effect, all named effects of a joint, or all changes in time. For example, a
scale error and five harmonics together imitate a step of a joint's angle, although the joint has none of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import background_without, score_together
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import Scored, refined
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.structure.ranked_terms import imitating, in_parts, rank_terms, ranked_once, refined_once
from scalar.effects import Effect
from scalar.effects.title import only_joint

# Largest ratio of the held-out error [m, all poses weighted alike] after to before, with which named effects give way to a flexible term, or are
# dropped when one was added. Weighted rows may hide that it predicts other poses worse: on a measured arm the error at poses held out grew threefold.
MOST_GROWTH = 1.2


@dataclass(frozen=True, eq=False)
class _Group:
    """Named effects of a state that one flexible term, or several together, may replace.

    Attributes:
        state: With the effects.
        indices: Of the effects of the group.
        background: Of the state without them.
        own: Their score together, given the other effects.
        imitated: The one among them that certain terms imitate; None if there is no such effect.
    """

    state: FittedState
    indices: Sequence[int]
    background: Background
    own: Scored
    imitated: Effect | None

    def replaced_by(self, effect: Effect) -> FittedState:
        """Return the state, refitted with an effect in the place of the group."""
        others = tuple(e for k, e in enumerate(self.state.effects) if k not in self.indices)
        return self.state.refitted(merged(others, effect))

    @property
    def may_be_several(self) -> bool:
        """Return whether several terms together may imitate an effect of the group. They are not tried in place of a spectrum of many orders."""
        return (
            self.imitated is not None
            and bool(self.imitated.partial_imitators(self.state.dataset))
            and self.own.dof <= self.state.settings.flexible_terms.most_coefficients_imitated
        )


def with_replacement(
    state: FittedState, named: CandidateSet, pools: Sequence[CandidateSet]
) -> FittedState | None:
    """Return the state in which one or several flexible terms replace a group of named effects that explains far less than they do, or None.

    Args:
        state: With the named effects.
        named: The candidate set of named effects.
        pools: The candidate sets of the flexible terms.
    """
    replaceable = list(groups(state.effects))
    if not replaceable:
        return None
    left_out = [background_without(state, indices) for indices in replaceable]
    # The state's own background as well, which is asked for next if nothing is replaced: the columns are then there.
    *ranked, _ = ranked_once(state, [*(without for without, _, _ in left_out), state.background()], pools)
    for indices, left, entries in zip(replaceable, left_out, ranked, strict=True):
        own = score_together(state, indices, pools[0], left)
        imitated = next(
            (state.effects[i] for i in indices if state.effects[i].imitators(state.dataset)), None
        )
        group = _Group(state, indices, left[0], own, imitated)
        if imitated is not None:
            entries = [*entries, *imitating(state, group.background, imitated)]
            entries.sort(key=lambda e: -e.evidence)
        trial = _replaced(group, entries, named, pools)
        if trial is not None:
            return trial
    return None


def _replaced(
    group: _Group, entries: Sequence[Scored], named: CandidateSet, pools: Sequence[CandidateSet]
) -> FittedState | None:
    """Return the state in which the first of the terms that qualifies, alone or with others, replaces a group, or None.

    Args:
        group: The effects to replace.
        entries: The terms with the most evidence in their place, best first.
        named: The candidate set of named effects.
        pools: The candidate sets of the flexible terms.
    """
    state, own, settings = group.state, group.own, group.state.settings
    # Several terms together are tried only with the best term as the first of them, because each attempt refits everything several times.
    together_from = max(entries, key=lambda e: e.evidence, default=None) if group.may_be_several else None
    for entry in entries:
        is_first = entry is together_from
        shapes = _shapes(group, entry, is_first)
        if entry.evidence < settings.flexible_terms.least_share_to_refine * own.evidence / shapes:
            continue
        best = refined_once(state, group.background, entry)
        several, better = None, best.evidence - own.evidence
        if is_first and group.imitated is not None and better <= settings.flexible_terms.replacement_margin:
            together, evidence = _with_partial_imitators(group.replaced_by(best.effect), group.imitated)
            if evidence - own.evidence > better:
                several, better = together, evidence - own.evidence
        least_gain = _least_gain(best.effect, better, settings)
        if least_gain is None:  # as of most terms, which are then not fitted
            continue
        trial = group.replaced_by(best.effect) if several is None else several
        if _predicts_worse(state, trial, best.effect) or not trial.is_plausible:
            continue
        # The scores above compare only the terms that are exchanged, linearised at the model with the named effects. After the refit, the whole
        # model has to explain the data better by the same margin.
        if _evidence_of(trial, named, pools) - _evidence_of(state, named, pools) > least_gain:
            return trial
    return None


def _shapes(group: _Group, entry: Scored, is_first: bool) -> int:
    """Return into how many terms a shape may be divided of which ``entry`` is the first: one, unless further terms may join it.

    They may join the first of several terms if the group has more coefficients than that term, which then has to explain only its share.
    """
    may_join = is_first and group.own.dof > entry.dof
    return 1 + group.state.settings.flexible_terms.most_further_shapes if may_join else 1


def _least_gain(effect: Effect, better: float, settings: Settings) -> float | None:
    """Return by how much the log evidence of the whole model has to grow with a replacement [nats]; None if the terms explain too little.

    Args:
        effect: The first of the terms.
        better: Log evidence of the terms in place of the named effects, less that of these [nats].
        settings: Thresholds.
    """
    margin = settings.flexible_terms.replacement_margin
    if better > margin:
        return margin
    # A strong error within profiles hardly shows in scores whose variance it has itself raised: the refitted models decide.
    return settings.selection.overwhelming_evidence if effect.of_instrument and better > 0 else None


def _predicts_worse(state: FittedState, trial: FittedState, effect: Effect) -> bool:
    """Return whether held-out poses are predicted worse after a replacement by terms of which ``effect`` is the first.

    A model with fewer coefficients may fit a little worse, but it must not predict worse; one that contains the named effect as a special case fits
    better in any case, and has to predict better.
    """
    now, then = (held_out_errors(each, state.whitening) for each in (state, trial))
    least = state.settings.selection.least_improvement
    worse = improvement(now, then) < least if effect.contains_imitated else improvement(then, now) >= least
    return worse or held_out_errors(trial).rms > MOST_GROWTH * held_out_errors(state).rms


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
    pools = in_parts(imitated.partial_imitators(state.dataset))
    first = len(state.effects) - 1
    best, evidence = state, -np.inf
    for _ in range(state.settings.flexible_terms.most_further_shapes):
        background = state.background()
        more = refined(state, background, rank_terms(state, [background], pools)[0][0])
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
    """Yield the groups of effects that one term could replace, as indices.

    They are all errors of a joint, these with what the joint alone gives way under a load, all that change in time or with a record, and each alone.
    """
    by_joint: dict[int, list[int]] = {}
    in_time = []
    for i, effect in enumerate(effects):
        if effect.erring_joint is not None:
            by_joint.setdefault(effect.erring_joint, []).append(i)
        if effect.is_change_in_time or effect.follows:
            in_time.append(i)
    with_load = [
        [i, *by_joint[joint]]
        for i, effect in enumerate(effects)
        if effect.load and (joint := only_joint(effect.target)) in by_joint
    ]
    yield from (indices for indices in [*with_load, *by_joint.values(), in_time] if len(indices) > 1)
    yield from ([i] for i, effect in enumerate(effects) if not effect.flexible)
