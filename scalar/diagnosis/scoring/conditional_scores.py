"""Score an effect of a state, and all candidates in its place, given the other effects of the state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import prod

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.ranking import Scored, rank, score_of
from scalar.diagnosis.scoring.score_test import Projected
from scalar.effects import Effect
from scalar.geometry.se3 import Array


def rivals(
    state: FittedState, i: int, columns: CandidateColumns, within: float = np.inf
) -> tuple[Scored, list[Scored]]:
    """Return the score of effect i of a state given the other effects, and the scores of all candidates in its place, best first.

    Candidates that are the same effect are among them.

    Args:
        state: The state with the effect.
        i: Index of the effect.
        columns: The candidates' columns at the state.
        within: By how much the log evidence of a candidate may be less than that of the effect [nats]; those with less are left out.
    """

    def scored() -> tuple[Scored, list[Scored]]:
        left_out = background_without(state, [i])
        own = score_together(state, [i], columns.candidates, left_out)
        return own, rank(state, left_out[0], columns, least=own.evidence - within)

    own, others = state.once(("rivals", i, columns.candidates, within), scored)
    return own, list(others)


def rivals_of_strongest_part(
    state: FittedState, i: int, own: Scored, columns: CandidateColumns, within: float = np.inf
) -> list[Scored]:
    """Return the scores of other candidates in place of the strongest part of effect i while its other parts stay in the model, best first.

    A part is a joint or an order. A series of a joint's orders may win against each single candidate only because it has several parts. If
    a candidate explains as much as the strongest part does, the other parts can stay in the model with that candidate just as well, and the data do
    not distinguish the two answers.

    Args:
        state: The state with the effect.
        i: Index of the effect.
        own: The score of the whole effect given the other effects.
        columns: The candidates' columns at the state.
        within: As for ``rivals``.

    Returns:
        Gain, degrees of freedom and evidence are those of the candidate together with the other parts, which stand in ``Scored.other_parts``;
        p-value and observability are those of the candidate alone. Candidates that are the same answer as the effect are left out. The list is empty
        if the effect has one part only, or if some of its coefficients are fixed.
    """
    parts = parts_of(state, i)
    if not parts:
        return []
    effect = state.effects[i]
    left_out = [_background_without(state, local, prior_std) for local, prior_std in parts]
    scores = [_score(state, [effect], columns.candidates, left) for left in left_out]
    strongest = int(np.argmax([score.gain for score in scores]))
    part, terms = scores[strongest], effect.parts()[strongest]
    rest = effect.with_terms([k for k in range(effect.n_terms) if k not in terms]).with_coefficients_of(
        effect
    )
    return [
        replace(
            s,
            gain=own.gain - part.gain + s.gain,
            dof=own.dof - part.dof + s.dof,
            evidence=own.evidence - part.evidence + s.evidence,
            other_parts=rest,
        )
        for s in rank(state, left_out[strongest][0], columns, least=part.evidence - within)
        if not s.effect.same_answer(effect)
    ]


def score_together(
    state: FittedState,
    indices: Sequence[int],
    candidates: CandidateSet,
    left_out: tuple[Background, Array, Array],
) -> Scored:
    """Return the joint score of several effects of a state given the others; ``Scored.effect`` is the first of the several.

    Args:
        state: The state with the effects.
        indices: Indices of the effects.
        candidates: The candidate set, for whose numbers of candidates evidence and p-value are corrected.
        left_out: What ``background_without`` returns for these effects.
    """
    return _score(state, [state.effects[i] for i in indices], candidates, left_out)


def without_weakest(
    state: FittedState,
    candidates: CandidateSet,
    doubted: Callable[[FittedState], Sequence[int]],
    is_needed: Callable[[Scored], bool],
) -> FittedState:
    """Return the state without those of some effects that are not needed given the others; the one with the least evidence is dropped first.

    Args:
        state: A fitted state.
        candidates: The candidate set, as for ``score_together``.
        doubted: Returns the indices of a state's effects that may be dropped.
        is_needed: Whether an effect with this score, given all others, stays.
    """
    while indices := doubted(state):
        scores = {i: score_together(state, [i], candidates, background_without(state, [i])) for i in indices}
        weakest = min(indices, key=lambda i: scores[i].evidence)
        if is_needed(scores[weakest]):
            break
        state = state.refitted([effect for i, effect in enumerate(state.effects) if i != weakest])
    return state


def _score(
    state: FittedState,
    effects: Sequence[Effect],
    candidates: CandidateSet,
    left_out: tuple[Background, Array, Array],
) -> Scored:
    """Return the joint score of the columns that were left out, which are those of some effects or of a part of one effect."""
    without, columns, prior_std = left_out
    # The model spans the columns, so what they have besides the rest of the model lies in the released directions.
    assert without.released is not None
    given = without.released.T @ columns
    squares = np.sum(columns * columns, axis=0)
    projected = Projected.with_gram(without, columns, given.T @ given, squares, prior_std)
    gain, dof, observability = (x[0] for x in projected.score(np.arange(columns.shape[1])[None]))
    # An effect of a kind that is not among the candidates counts as a change, which is tried at every pose.
    family = prod(candidates.of_kind(effect) or state.dataset.n_poses for effect in effects)
    return score_of(
        without, effects[0], float(gain), int(dof), float(observability), family, candidates.total
    )


def background_without(state: FittedState, indices: Sequence[int]) -> tuple[Background, Array, Array]:
    """Return the background of a state without some effects, the columns of the k free coefficients of these effects, and their prior std.

    The columns ``(N m, k)`` are whitened; N is the number of poses, m that of rows per pose. The prior standard deviations ``(k,)`` are infinite for
    coefficients without a prior.
    """
    return state.once(
        ("background without", *indices),
        lambda: _background_without(state, *columns_of_effects(state, indices)),
    )


def _background_without(
    state: FittedState, local: Array, prior_std: Array
) -> tuple[Background, Array, Array]:
    """Return what ``background_without`` does, without the free columns ``local`` ``(F,)`` bool with prior standard deviations ``(k,)``."""
    background = without_columns(state.background(), state, local)
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    return background, whitened(state.whitening, state.linearised()[1][:measured, local]), prior_std


def without_columns(background: Background, state: FittedState, local: Array) -> Background:
    """Return a background of a state without some of its free columns.

    Args:
        background: The background of the state, under any whitening.
        state: The state.
        local: ``(F,)`` bool, the k free columns that are left out.
    """
    return background.without(local, state.model.vector[state.free][local])


def columns_of_effects(state: FittedState, indices: Sequence[int]) -> tuple[Array, Array]:
    """Return which of a state's F free columns are those of some effects ``(F,)`` bool, and the prior standard deviations of these ``(k,)``."""
    start = state.model.blocks["effects"].start
    ends = start + np.cumsum([0, *(len(effect.coefficients) for effect in state.effects)])
    of_effects = np.zeros(len(state.free), dtype=bool)
    prior_std = np.full(len(state.free), np.inf)
    for i in indices:
        of_effects[ends[i] : ends[i + 1]] = True
        prior_std[ends[i] : ends[i + 1]] = state.effects[i].prior_std
    return of_effects[state.free], prior_std[of_effects & state.free]


def parts_of(state: FittedState, i: int) -> list[tuple[Array, Array]]:
    """Return for each part of effect i of a state (a joint or an order) its w free columns ``(F,)`` bool and their prior std ``(w,)``.

    The list is empty if the effect has one part only, or if some of its coefficients are fixed because they are unobservable.
    """
    effect = state.effects[i]
    parts = effect.parts()
    of_effect, _ = columns_of_effects(state, [i])
    where = np.flatnonzero(of_effect)
    if len(parts) == 1 or len(where) != len(effect.coefficients):
        return []
    width = len(effect.coefficients) // effect.n_terms
    found = []
    for terms in parts:
        columns = np.concatenate([np.arange(k * width, (k + 1) * width) for k in terms])
        part = np.zeros(len(of_effect), dtype=bool)
        part[where[columns]] = True
        found.append((part, effect.prior_std[columns]))
    return found
