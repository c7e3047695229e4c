"""Structure beyond doubt that no name fits: found by flexible terms, judged harder than a name, and never forced into the nearest one."""

from __future__ import annotations

from scalar.diagnosis.candidates import flexible
from scalar.diagnosis.holdout import held_out, improvement, no_worse
from scalar.diagnosis.hunt import Bank, Columns, background_without, hunt, merged, rank, reconsidered, rivals
from scalar.diagnosis.score import Background
from scalar.diagnosis.state import State, settle
from scalar.effects.unattributed import Unattributed

ALPHA = 1e-5  # chance of seeing structure where there is none, corrected for all terms that were tried
LEAST_IMPROVEMENT = (
    2.0  # standard errors by which the held-out error has to fall, blocks being few and unlike
)
BETTER_THAN_A_NAME = 10.0  # nats by which a flexible term has to explain better to unseat a name
MAX_TERMS = 2


def with_unnamed(state: State, named: Bank) -> State:
    """Return a state with flexible terms for what its named effects leave, the names judged again beside them.

    Args:
        state: Where the hunt for names ended.
        named: What has a name.
    """
    pool = Bank.of(flexible(state.dataset))
    state = _unseated(state, pool)
    for _ in range(MAX_TERMS):
        trial = _with_best(state, pool)
        if trial is None:
            break
        state = hunt(reconsidered(trial, named)[0], named).after
    return reconsidered(state, named)[0]


def _with_best(state: State, pool: Bank) -> State | None:
    """Return the state with the flexible term that the residual bears out best, or None."""
    background: Background = state.background()
    for entry in rank(state, background, Columns(state, pool))[:4]:
        if entry.p_value > ALPHA or entry.evidence <= 0:
            return None
        trial = settle(state.dataset, state.model, state.geometry_free, merged(state.effects, entry.effect))
        gain = improvement(held_out(state, state.mix), held_out(trial, state.mix))
        if gain >= LEAST_IMPROVEMENT and no_worse(held_out(state), held_out(trial)):
            return trial
    return None


def _unseated(state: State, pool: Bank) -> State:
    """Return a state in which every name explains its share about as well as the best flexible term would."""
    cols = Columns(state, pool)
    for i, effect in enumerate(state.effects):
        if isinstance(effect, Unattributed):
            continue
        own, without = rivals(state, i, cols)[0], background_without(state, i)[0]
        best = rank(state, without, cols)[0]
        if best.evidence > own.evidence + BETTER_THAN_A_NAME:
            others = tuple(e for k, e in enumerate(state.effects) if k != i)
            trial = settle(state.dataset, state.model, state.geometry_free, merged(others, best.effect))
            better = trial.background().squared < state.background().squared
            if better and no_worse(held_out(state), held_out(trial)):
                return trial
    return state
