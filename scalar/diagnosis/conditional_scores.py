"""How an effect that a state has scores given the others, and how everything else would score in its place."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np

from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.diagnosis.ranking import Scored, rank, score_of
from scalar.diagnosis.score_test import Background, Projected
from scalar.geometry.se3 import Array


def rivals(state: FittedState, i: int, columns: CandidateColumns) -> tuple[Scored, list[Scored]]:
    """Return how effect i of a state scores given the others, and how everything else would score in its place."""
    left_out = background_without(state, [i])
    return together(state, [i], columns.candidates, left_out), rank(state, left_out[0], columns)


def together(
    state: FittedState,
    indices: Sequence[int],
    candidates: CandidateSet,
    left_out: tuple[Background, Array, Array],
) -> Scored:
    """Return the score of several effects of a state together, given the others, under the name of the first.

    Args:
        state: With the effects.
        indices: Which.
        candidates: The candidate set.
        left_out: As ``background_without`` gives it for these effects.
    """
    without, mine, sizes = left_out
    # What is left of the effects' own columns given the others; rows of priors have no part in other effects.
    assert without.released is not None
    left = without.released.T @ mine
    projected = Projected.with_gram(without, mine, left.T @ left, np.sum(mine * mine, axis=0), sizes)
    gain, dof, observability = (x[0] for x in projected.score(np.arange(mine.shape[1])[None]))
    effects = [state.effects[i] for i in indices]
    families = [sum(c.name == e.name for c, _ in candidates.tried) for e in effects]
    family = prod(count or state.dataset.n_poses for count in families)
    return score_of(
        without, effects[0], float(gain), int(dof), float(observability), family, candidates.total
    )


def background_without(state: FittedState, indices: Sequence[int]) -> tuple[Background, Array, Array]:
    """Return the background of a state without some effects, those effects' free columns ``(N m, k)`` and prior standard deviations ``(k,)``."""
    local, sizes = columns_of_effects(state, indices)
    background = without_columns(state.background(), state, local, sizes)
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    return background, whitened(state.whitening, state.linearised()[1][:measured, local]), sizes


def without_columns(background: Background, state: FittedState, local: Array, sizes: Array) -> Background:
    """Return a background of a state without some of its free columns ``(F,)`` with prior standard deviations ``(k,)``, where finite."""
    return background.without(local, state.model.vector[state.free][local], int(np.isfinite(sizes).sum()))


def columns_of_effects(state: FittedState, indices: Sequence[int]) -> tuple[Array, Array]:
    """Return which of a state's free columns ``(F,)`` are those of some effects, and their prior standard deviations ``(k,)``."""
    start = state.model.blocks["effects"].start
    ends = start + np.cumsum([0, *(len(effect.coefficients) for effect in state.effects)])
    mine = np.zeros(len(state.free), dtype=bool)
    sizes = np.full(len(state.free), np.inf)
    for i in indices:
        mine[ends[i] : ends[i + 1]] = True
        sizes[ends[i] : ends[i + 1]] = state.effects[i].prior_std
    return mine[state.free], sizes[mine & state.free]
