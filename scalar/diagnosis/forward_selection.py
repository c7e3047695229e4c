"""Forward selection: score every candidate, add the best, refit everything, judge on held-out poses, and repeat.

A candidate is taken if its gain is beyond chance, corrected for all that were tried, and if it lowers the error on held-out poses. After every
step what is already in the model must still earn its place, and may be replaced by what explains the same better, so that the order in which
effects are found does not decide the answer.
"""

from __future__ import annotations

from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.conditional_scores import rivals
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.merging import merged
from scalar.diagnosis.ranking import Scored, rank, refined


def select_forward(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with every effect of a candidate set that the data bear out."""
    if state.background().variance < state.settings.selection.rounding:
        return state
    refused: set[str] = set()
    columns = CandidateColumns(state, candidates)
    for _ in range(state.settings.selection.max_effects):
        better = _better(state, columns, refused)
        if better is None:
            break
        state, columns = reconsidered(better, candidates)
    return state


def _better(state: FittedState, columns: CandidateColumns, refused: set[str]) -> FittedState | None:
    """Return the state with the best candidate that poses held out bear out, or None; those they do not bear out are refused from now on."""
    before, before_whitened = held_out_errors(state), held_out_errors(state, state.whitening)
    for entry in _best(state, columns):
        if entry.effect.label in refused:
            continue
        trial = state.refitted(merged(state.effects, entry.effect))
        gain = improvement(before_whitened, held_out_errors(trial, state.whitening))
        if gain >= state.settings.selection.least_improvement and no_worse(before, held_out_errors(trial)):
            return trial
        refused.add(entry.effect.label)
    return None


def _best(state: FittedState, columns: CandidateColumns) -> list[Scored]:
    """Return the few candidates that are beyond chance and explain most, refined, best first."""
    background, settings = state.background(), state.settings.selection
    worth = [
        e
        for e in rank(state, background, columns)[: settings.tried]
        if e.p_value <= settings.alpha_named_effect and e.evidence > 0
    ]
    return sorted((refined(state, background, e) for e in worth), key=lambda entry: -entry.evidence)


def reconsidered(state: FittedState, candidates: CandidateSet) -> tuple[FittedState, CandidateColumns]:
    """Return a state in which every effect earns its place and none could be replaced by a better one, with its columns."""
    columns, settings = CandidateColumns(state, candidates), state.settings.selection
    for _ in range(4 + len(state.effects)):
        changed = False
        for i, effect in enumerate(state.effects):
            others = tuple(e for k, e in enumerate(state.effects) if k != i)
            own, ranking = rivals(state, i, columns)
            if own.evidence <= 0 or own.p_value > settings.alpha_named_effect:
                state, changed = state.refitted(others), True
                break
            best = ranking[0]
            if best.effect.label != effect.label and best.evidence > own.evidence + settings.swap_margin:
                trial = state.refitted(merged(others, best.effect))
                # Under its own whitening a worse fit is excused by the variance component that it leaves.
                left = trial.background_whitened_by(state.whitening).squared
                better = left < state.background().squared + 1e-9
                if (better or best.dof < own.dof) and no_worse(
                    held_out_errors(state), held_out_errors(trial)
                ):
                    state, changed = trial, True
                    break
        if not changed:
            break
        columns = CandidateColumns(state, candidates)
    return state, columns
