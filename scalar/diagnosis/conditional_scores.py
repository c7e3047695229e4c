"""Score an effect of a state given its other effects, and all candidates in its place."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np

from scalar.diagnosis.background import Background
from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.diagnosis.ranking import Scored, rank, score_of
from scalar.diagnosis.score_test import Projected
from scalar.geometry.se3 import Array


def rivals(state: FittedState, i: int, columns: CandidateColumns) -> tuple[Scored, list[Scored]]:
    """Return the score of effect i of a state given its other effects, and the scores of all candidates in its place."""
    left_out = background_without(state, [i])
    return score_together(state, [i], columns.candidates, left_out), rank(state, left_out[0], columns)


def score_together(
    state: FittedState,
    indices: Sequence[int],
    candidates: CandidateSet,
    left_out: tuple[Background, Array, Array],
) -> Scored:
    """Return the joint score of several effects of a state given its other effects; ``Scored.effect`` is the first of them.

    Args:
        state: The state with the effects.
        indices: Indices of the effects.
        candidates: The candidate set, from which the numbers of candidates are taken.
        left_out: What ``background_without`` returns for these effects.
    """
    without, columns, prior_std = left_out
    # The products of the effects' own columns, conditional on the rest of the model.
    assert without.released is not None
    given = without.released.T @ columns
    squares = np.sum(columns * columns, axis=0)
    projected = Projected.with_gram(without, columns, given.T @ given, squares, prior_std)
    gain, dof, observability = (x[0] for x in projected.score(np.arange(columns.shape[1])[None]))
    effects = [state.effects[i] for i in indices]
    families = [sum(c.name == e.name for c, _ in candidates.tried) for e in effects]
    family = prod(count or state.dataset.n_poses for count in families)
    return score_of(
        without, effects[0], float(gain), int(dof), float(observability), family, candidates.total
    )


def background_without(state: FittedState, indices: Sequence[int]) -> tuple[Background, Array, Array]:
    """Return the background of a state without some effects, the free columns of these effects ``(N m, k)`` and their prior standard deviations.

    The prior standard deviations are ``(k,)``, infinite for coefficients without a prior.
    """
    local, prior_std = columns_of_effects(state, indices)
    background = without_columns(state.background(), state, local, prior_std)
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    return background, whitened(state.whitening, state.linearised()[1][:measured, local]), prior_std


def without_columns(background: Background, state: FittedState, local: Array, prior_std: Array) -> Background:
    """Return a background of a state without some of its free columns.

    Args:
        background: The background of the state, under any whitening.
        state: The state.
        local: ``(F,)`` bool, the k free columns that are left out.
        prior_std: ``(k,)``, prior standard deviations of their coefficients, infinite for those without a prior.
    """
    return background.without(local, state.model.vector[state.free][local], int(np.isfinite(prior_std).sum()))


def columns_of_effects(state: FittedState, indices: Sequence[int]) -> tuple[Array, Array]:
    """Return which of a state's free columns ``(F,)`` bool are those of some effects, and their prior standard deviations ``(k,)``."""
    start = state.model.blocks["effects"].start
    ends = start + np.cumsum([0, *(len(effect.coefficients) for effect in state.effects)])
    mine = np.zeros(len(state.free), dtype=bool)
    prior_std = np.full(len(state.free), np.inf)
    for i in indices:
        mine[ends[i] : ends[i + 1]] = True
        prior_std[ends[i] : ends[i + 1]] = state.effects[i].prior_std
    return mine[state.free], prior_std[mine & state.free]
