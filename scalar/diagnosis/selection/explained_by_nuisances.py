"""Drop effects of the arm that are not needed given what every set-up has to a small degree: no plane is flat, and no scanner's zero is exact.

The bows of target planes are small, and forward selection may find an effect of the arm that describes the bows of several planes at once with fewer
coefficients: a scale error of a joint, or a harmonic of the first order. The log evidence favours such an effect, because it counts coefficients and
counts each bow as a choice among all candidates. What every set-up has (``Effect.in_every_setup``, called nuisances here) is no such choice, however.
Every effect of the arm is therefore scored once more given all nuisances.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import without_weakest
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.effects import Effect
from scalar.effects.registry import missing_nuisances


def explained_by_nuisances(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state in which nuisances replace those effects of the arm that explain next to nothing given them, or the state as it is.

    Next to nothing is at most ``confounded_margin`` [nats] of log evidence. Nuisances that explain nothing themselves are left out again. The state
    is returned as it is if the result is implausible, if its log evidence is smaller by more than that margin (the new nuisances not counted as a
    choice among the candidates), if held-out poses are predicted clearly worse with it, or if it contains some nuisances of a kind but not most.

    Args:
        state: The state with the effects that were selected.
        candidates: The candidate set.
    """
    new, settings = missing_nuisances(state.dataset, state.effects), state.settings.selection
    of_arm = [effect for effect in state.effects if effect.acts_on_arm]
    if not new or not of_arm:
        return state
    with_all = _needed(state.refitted((*state.effects, *new)), candidates, of_arm, settings.confounded_margin)
    if all(any(e.same_place(other) for other in with_all.effects) for e in state.effects):
        return state
    trial = _needed(with_all, candidates, new, 0.0)
    if not all(_most_are_there(kind, trial) for kind in {type(effect) for effect in new}):
        return state
    added = len([e for e in trial.effects if any(e.same_place(other) for other in new)])
    lost = evidence_of(state, candidates) - evidence_of(trial, candidates) - added * np.log(candidates.total)
    if not trial.is_plausible or lost > settings.confounded_margin:
        return state
    worse = improvement(held_out_errors(trial, state.whitening), held_out_errors(state, state.whitening))
    return state if worse >= settings.least_improvement else trial


def _most_are_there(kind: type[Effect], state: FittedState) -> bool:
    """Return whether a state has none of the nuisances of a kind, or most of them: planes bend alike, so a single bow among many is a guess."""
    there = sum(isinstance(effect, kind) for effect in state.effects)
    return there == 0 or 2 * there > len(kind.candidates(state.dataset))


def _needed(
    state: FittedState, candidates: CandidateSet, doubted: Sequence[Effect], least: float
) -> FittedState:
    """Return the state without those of some effects that explain too little given the others, the one that explains least dropped first.

    Args:
        state: A fitted state.
        candidates: The candidate set.
        doubted: The effects that may be dropped.
        least: Log evidence [nats] that each of them needs.
    """

    def indices(of: FittedState) -> list[int]:
        return [i for i, e in enumerate(of.effects) if any(e.same_place(other) for other in doubted)]

    return without_weakest(state, candidates, indices, lambda score: score.evidence > least)
