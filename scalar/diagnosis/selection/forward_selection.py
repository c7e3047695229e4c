"""Forward selection: score every candidate, add the best, refit everything, judge on held-out poses, and repeat.

A candidate is added if its gain is significant, corrected for the number of candidates, and if it lowers the error on held-out poses. After every
step each effect of the model is tested again given the others: it is dropped if it is no longer significant, and replaced if another candidate
explains the same part of the residual better. The result therefore does not depend on the order in which effects are found.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.conditional_scores import (
    background_without,
    rivals,
    rivals_of_strongest_part,
    score_together,
)
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import Scored, rank, refined
from scalar.diagnosis.settings import SelectionSettings
from scalar.effects import Effect


def select_forward(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return a state to which all those effects of a candidate set are added that the data support."""
    if state.is_rounding:
        return state
    refused: set[str] = set()
    columns = CandidateColumns.of(state, candidates)
    seen = {_answer(state)}
    for _ in range(state.settings.selection.max_effects):
        found = _with_best_candidate(state, columns, refused)
        if found is None:
            break
        better, label = found
        state, columns = reconsidered(better, candidates)
        # A candidate that the other effects then push out again, or whose addition leads back to an earlier answer, would be added for ever.
        if _answer(state) in seen:
            refused.add(label)
        seen.add(_answer(state))
    return state


def _answer(state: FittedState) -> frozenset[str]:
    """Return the labels of the effects of a state."""
    return frozenset(effect.label for effect in state.effects)


def _with_best_candidate(
    state: FittedState, columns: CandidateColumns, refused: set[str]
) -> tuple[FittedState, str] | None:
    """Return the state with the best candidate that held-out poses confirm, and the label of this candidate; or None.

    Args:
        state: The fitted state.
        columns: The candidates' columns in it.
        refused: Labels of candidates that were not confirmed before; those that are not confirmed here are added to it.
    """
    before, before_whitened = held_out_errors(state), held_out_errors(state, state.whitening)
    for entry in _significant_candidates(state, columns):
        if entry.effect.label in refused or not _has_enough_evidence(
            entry, state.effects, state.settings.selection
        ):
            continue
        trial = state.refitted(merged(state.effects, entry.effect))
        gain = improvement(before_whitened, held_out_errors(trial, state.whitening))
        clearly = trial.is_plausible and gain >= state.settings.selection.least_improvement
        if clearly and no_worse(before, held_out_errors(trial)):
            return trial, entry.effect.label
        refused.add(entry.effect.label)
    return None


def _significant_candidates(state: FittedState, columns: CandidateColumns) -> list[Scored]:
    """Return the significant ones among the candidates with the most evidence, their nonlinear parameters refined, best first."""
    background, settings = state.background(), state.settings.selection
    significant = [
        e
        for e in rank(state, background, columns, settings.most_candidates_tried)
        if e.p_value <= settings.alpha_named_effect and e.evidence > 0
    ]
    return sorted((refined(state, background, e) for e in significant), key=lambda entry: -entry.evidence)


def reconsidered(state: FittedState, candidates: CandidateSet) -> tuple[FittedState, CandidateColumns]:
    """Return a state in which every effect is significant and no candidate in its place explains the data better, and the columns in that state."""
    columns, settings = CandidateColumns.of(state, candidates), state.settings.selection
    # Candidates that explain still less than the effect replace nothing.
    within = max(settings.swap_margin, settings.same_load_margin)
    for _ in range(4 + len(state.effects)):
        changed = False
        for i in range(len(state.effects)):
            others = tuple(e for k, e in enumerate(state.effects) if k != i)
            own, ranking = rivals(state, i, columns, within)
            superfluous = not _has_enough_evidence(own, others, settings) and _weakest_of_load(
                state, i, own, columns.candidates
            )
            if own.evidence <= 0 or own.p_value > settings.alpha_named_effect or superfluous:
                state, changed = state.refitted(others), True
                break
            ranking += rivals_of_strongest_part(state, i, own, columns, within)
            trial = _replaced(state, others, own, ranking)
            if trial is not None:
                state, changed = trial, True
                break
        if not changed:
            break
        columns = CandidateColumns.of(state, candidates)
    return state, columns


def _has_enough_evidence(entry: Scored, others: Sequence[Effect], settings: SelectionSettings) -> bool:
    """Return whether an effect may join others or stay with them: it needs more evidence if one of the others is caused by the same load."""
    return entry.evidence > settings.same_load_margin or not _of_same_load(others, entry.effect)


def _of_same_load(others: Sequence[Effect], effect: Effect) -> list[Effect]:
    """Return the other effects of the same load as an effect, at other places."""
    return [e for e in others if effect.load and e.load == effect.load and not e.same_place(effect)]


def _weakest_of_load(state: FittedState, i: int, own: Scored, candidates: CandidateSet) -> bool:
    """Return whether effect i, whose score is ``own``, has the least evidence of all effects of its load."""
    partners = [[state.effects.index(e)] for e in _of_same_load(state.effects, state.effects[i])]
    scores = [score_together(state, k, candidates, background_without(state, k)) for k in partners]
    return all(own.evidence <= score.evidence for score in scores)


def _replaced(
    state: FittedState, others: tuple[Effect, ...], own: Scored, ranking: list[Scored]
) -> FittedState | None:
    """Return the state in which another candidate takes an effect's place, or None.

    The candidate has to explain the same part of the residual clearly better. If it is a further term of another effect of the state, it need only
    explain it about as well, because an explanation with one cause less is more probable. Where a change in time has a form that follows a recorded
    column instead (growth with the temperature in place of a warm-up by the clock), that form need only explain it about as well. The search for the
    time constant favours the warm-up, since the constant counts as a coefficient only afterwards; and only growth with the temperature holds in
    another campaign. A step likewise replaces a creep that explains it little better, since the length of the creep was chosen as well. An effect of
    the arm has to explain still more to replace one that every set-up has (``Effect.in_every_setup``).

    Args:
        state: The state with the effect.
        others: Its other effects.
        own: The score of the effect given the others.
        ranking: The scores of the candidates in its place, or in that of its strongest part, but for those that explain far less.
    """
    if not ranking:
        return None
    settings, best = state.settings.selection, max(ranking, key=lambda r: r.evidence)
    margin = settings.swap_margin
    joining = next(
        (
            r
            for r in ranking
            if r.evidence > own.evidence - _joining_margin(own, r, settings)
            and r.other_parts is None
            and len(merged(others, r.effect)) == len(others)
        ),
        None,
    )
    recorded = next((r for r in ranking if _follows_a_record(r, own, margin)), None)
    sudden = next((r for r in ranking if _is_sudden_form(r, own, margin)), None)
    favoured = own.effect.in_every_setup and best.effect.acts_on_arm
    more = margin + (settings.confounded_margin if favoured else 0.0)
    better = best.effect.label != own.effect.label and best.evidence > own.evidence + more
    for entry in (best if better else None, recorded, sudden, joining):
        if entry is None:
            continue
        allowance = margin if entry is sudden else 0.0
        if entry is joining and entry is not sudden:
            allowance = _joining_margin(own, entry, settings)
        kept = others if entry.other_parts is None else (*others, entry.other_parts)
        trial = state.refitted(merged(kept, entry.effect))
        # Both fits are compared under the same whitening, because the larger variance component of a worse fit would hide that it is worse.
        left, now = trial.background_whitened_by(state.whitening), state.background()
        lost = 0.5 * now.degrees_of_freedom * np.log(left.sum_of_squares / now.sum_of_squares)
        explains = (
            lost <= allowance + 1e-9
            or entry is recorded
            or (entry is best and better and entry.dof < own.dof)
        )
        if explains and trial.is_plausible and no_worse(held_out_errors(state), held_out_errors(trial)):
            return trial
    return None


def _follows_a_record(entry: Scored, own: Scored, margin: float) -> bool:
    """Return whether an effect changes with the clock, and a candidate is the form of it that follows a recorded column and explains it no worse.

    The clock has a time constant that is fitted, and so follows a recorded temperature closely; it says nothing of other days.
    """
    by_the_clock = own.effect.is_change_in_time and not entry.effect.is_change_in_time
    return by_the_clock and _is_another_form(entry, own, margin)


def _is_sudden_form(entry: Scored, own: Scored, margin: float) -> bool:
    """Return whether a candidate is a step in place of a change of the same kind and place that takes its time, and explains it little worse."""
    slow = own.effect.takes_time and not entry.effect.takes_time
    return slow and _is_another_form(entry, own, margin)


def _is_another_form(entry: Scored, own: Scored, margin: float) -> bool:
    """Return whether a candidate stands in place of a whole effect, acts at the same place, and explains it worse by less than a margin [nats]."""
    return (
        entry.other_parts is None
        and entry.effect.same_place(own.effect)
        and entry.evidence > own.evidence - margin
    )


def _joining_margin(own: Scored, entry: Scored, settings: SelectionSettings) -> float:
    """Return by how much less a further term of another effect may explain than an effect whose place it takes [nats]."""
    same_load = bool(own.effect.load) and entry.effect.load == own.effect.load
    return settings.same_load_margin if same_load else settings.swap_margin
