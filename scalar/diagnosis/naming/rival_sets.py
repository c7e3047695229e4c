"""How clearly the data prefer an effect to the best set of other effects in its place.

A rival is a single candidate in an effect's place. On measured arms, which err in more ways than a model has effects, two or three effects together
may explain the same. Another half of the same campaign then chooses these, and the name is not found again. Each effect is therefore also compared
with sets: a rival, and the candidates that explain most of what it leaves, one after the other.

The lead of the effect is the difference of log evidence [nats] of the two models. The log likelihood ratio of two models that are both wrong varies
from pose to pose, and its sum over the poses has a standard error that follows from this scatter (Vuong, Econometrica 57, 1989). Where one of the
models is right, the lead is many standard errors; where both only resemble the cause, it is a few nats although the models differ much. Poses that
repeat each other count as one. The lead without this error would be log odds. The probability of the effect is therefore that of a normal variable
whose variance is the squared standard error and that of the logistic distribution.
Everything is computed from the columns at the state's optimum, without a refit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.plausibility import is_implausible
from scalar.diagnosis.held_out.repetitions import first_of_repetitions, moving_joints
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns
from scalar.diagnosis.scoring.conditional_scores import background_without, columns_of_effects, rivals
from scalar.diagnosis.scoring.ranking import Scored, rank
from scalar.diagnosis.scoring.score_test import fall
from scalar.effects import Effect
from scalar.geometry.se3 import Array

_FIRST = 3  # chosen: number of rivals, the best ones, with which sets begin
_FURTHER = 2  # chosen: most further effects of a set
_TRIED = 6  # candidates that are looked at for one that is possible
_STD_OF_LOGISTIC = np.pi / 3**0.5  # of the distribution whose cumulative probabilities are those of log odds
CLEAR_ODDS = 20.0  # nats, chosen: with larger log odds against all single rivals, no sets are looked for


@dataclass(frozen=True, eq=False)
class RivalSet:
    """The set of effects that comes nearest to an effect.

    Attributes:
        effects: The effects of the set, the one that stands for the effect first.
        lead: Log evidence of the effect less that of the set [nats], each in the model with the candidates that explain most of what it leaves.
        std: Standard error of the lead [nats].
    """

    effects: tuple[Effect, ...]
    lead: float
    std: float

    @property
    def probability(self) -> float:
        """Return the probability of the effect if one of the two is the cause."""
        return float(ndtr(self.lead / np.hypot(self.std, _STD_OF_LOGISTIC)))


@dataclass(frozen=True, eq=False)
class _Extended:
    """A model with some of a state's columns and further effects.

    Attributes:
        added: The further effects.
        penalty: What their log evidence has less than half the fall of the logarithm of the sum of squares [nats]: for coefficients and choices.
        background: The residual of this model.
    """

    added: tuple[Effect, ...]
    penalty: float
    background: Background


def nearest_set(state: FittedState, i: int, columns: CandidateColumns) -> RivalSet | None:
    """Return the set of effects over which effect i of a state leads least; None if nothing else explains anything in its place.

    Args:
        state: The fitted state.
        i: Index of an effect that has a name.
        columns: The columns of the named candidates at the state.
    """
    effect = state.effects[i]
    own, ranking = rivals(state, i, columns)
    of_effect, _ = columns_of_effects(state, [i])
    own_background = background_without(state, [i])[0]
    own_penalty = _penalty(own_background, own)
    complete = state.once(
        ("extended by candidates", columns.candidates),
        lambda: _extended(state, columns, np.zeros_like(of_effect), state.background()),
    )
    found: list[RivalSet] = []
    for entry in ranking:
        if entry.evidence <= 0 or len(found) == _FIRST:
            break
        if entry.effect.same_answer(effect) or not _is_possible(state, of_effect, [entry.effect]):
            continue
        instead = _extended(state, columns, of_effect, own_background, entry, effect)
        with_effect, with_set = complete.background, instead.background
        ratio = np.log(with_set.sum_of_squares / max(with_effect.sum_of_squares, 1e-300))
        lead = 0.5 * with_effect.degrees_of_freedom * ratio - own_penalty - complete.penalty + instead.penalty
        found.append(RivalSet(instead.added, float(lead), _standard_error(state, with_effect, with_set)))
    return min(found, key=lambda rival: rival.lead, default=None)


def _extended(
    state: FittedState,
    columns: CandidateColumns,
    removed: Array,
    background: Background,
    first: Scored | None = None,
    excluded: Effect | None = None,
) -> _Extended:
    """Return the model of a state with further effects, each the one that explains most given those before it.

    Args:
        state: The state.
        columns: The candidates' columns at the state.
        removed: ``(F,)`` bool, which of the state's free columns the model does not have.
        background: The residual of the state without these columns.
        first: The score of the effect that is added first, or None.
        excluded: An effect that is not added, under any of its forms.
    """
    added: tuple[Effect, ...] = ()
    penalty, entry = 0.0, first
    for _ in range(_FURTHER + (first is not None)):
        entry = entry or _best(state, columns, background, removed, added, excluded)
        if entry is None:
            break
        added, penalty = (*added, entry.effect), penalty + _penalty(background, entry)
        background = Background.of(*_rows(state, removed, added), *_shape(state), state.settings.score_test)
        entry = None
    return _Extended(added, penalty, background)


def _penalty(background: Background, entry: Scored) -> float:
    """Return by how much the log evidence of a candidate is less than half the fall of the logarithm of the sum of squares that it makes [nats]."""
    return float(0.5 * fall(background, np.array(entry.gain), np.array(entry.dof)) - entry.evidence)


def _best(
    state: FittedState,
    columns: CandidateColumns,
    background: Background,
    removed: Array,
    added: tuple[Effect, ...],
    excluded: Effect | None,
) -> Scored | None:
    """Return the score of the candidate that explains most given a background, among those that are possible; None if none explains anything."""
    ranking = rank(state, background, columns.given(background), least=1e-9)
    scores = [s for s in ranking if excluded is None or not s.effect.same_answer(excluded)]
    return next((s for s in scores[:_TRIED] if _is_possible(state, removed, [*added, s.effect])), None)


def _shape(state: FittedState) -> tuple[int, int]:
    """Return the numbers of poses and of rows per pose."""
    return state.dataset.n_poses, state.residuals.measurement.rows_per_pose


def _rows(state: FittedState, removed: Array, added: Sequence[Effect]) -> tuple[Array, Array]:
    """Return residual and Jacobian, whitened, without the columns ``removed`` ``(F,)`` bool and with those of further effects."""
    residual, J = (whitened(state.whitening, rows) for rows in state.linearised())
    residual = residual - J[:, removed] @ state.model.vector[state.free][removed]
    columns = state.columns_of(added) if added else np.zeros((0, 0))
    below = np.zeros((len(residual) - len(columns), columns.shape[1]))  # rows of priors
    return residual, np.column_stack([J[:, ~removed], np.vstack([columns, below])])


def _is_possible(state: FittedState, removed: Array, added: Sequence[Effect]) -> bool:
    """Return whether further effects, fitted in place of the columns ``removed`` ``(F,)`` bool, have sizes and signs that their causes can have."""
    residual, J = _rows(state, removed, added)
    ends = np.cumsum([len(effect.coefficients) for effect in added])
    fitted = -np.linalg.lstsq(J, residual, rcond=state.settings.score_test.rank_tolerance)[0][-ends[-1] :]
    robot, poses = state.dataset.robot, state.residuals.poses
    most = state.settings.selection.plausible_coefficient
    sized = (
        effect.with_coefficients(coefficients)
        for effect, coefficients in zip(added, np.split(fitted, ends[:-1]), strict=True)
    )
    return not any(
        is_implausible(effect, robot, poses, most) or effect.against_its_load(robot, poses)
        for effect in sized
    )


def _standard_error(state: FittedState, own: Background, other: Background) -> float:
    """Return the standard error of the log likelihood ratio of two models [nats], from its scatter over poses that do not repeat each other."""
    each = 0.5 * np.sum(other.residual**2 / other.variance - own.residual**2 / own.variance, axis=1)
    first = first_of_repetitions(state.dataset.q[:, moving_joints(state)])
    sums = np.bincount(np.unique(first, return_inverse=True)[1].ravel(), weights=each)
    return float(np.std(sums, ddof=1) * np.sqrt(len(sums))) if len(sums) > 1 else np.inf
