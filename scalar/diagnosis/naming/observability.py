"""Unobservable effects: the other parameters absorb them, so they leave no residual, but predictions at other poses may be wrong.

If an effect with coefficient c is present and not in the model, the fit moves the free parameters by ``J^+ E c``, with J and E the whitened columns
of the parameters and of the effect, and leaves the residual ``(I - J J^+) E c``. If that is almost zero, the effect is unobservable.
Its consequence is the difference between ``J^+ E c`` and the effect itself in the predicted positions, within the joint limits.

An effect may also be present unseen beside one that was found, if the two bear the same weight (``scalar.effects.same_weight``): where joints give
way, a base that gives way looks like more or less of their compliance. It is listed with the largest size that would not be seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.fit.effect_columns import Bases
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.predicted_displacements import displacements, random_poses
from scalar.effects import Effect
from scalar.effects.same_weight import ActsLikeCompliance, consequence_beside
from scalar.geometry.se3 import Array

# Chosen: an effect that would be seen from a smaller part of the compliance that was found is not listed beside it.
_LEAST_PART = 0.2
_RANK_TOLERANCE = 1e-10  # smaller singular values of the parameters' columns, over the largest, count as zero


@dataclass(frozen=True, eq=False)
class Unobservable:
    """An effect that leaves no residual in these data.

    Attributes:
        effect: The effect, with coefficients of zero.
        observability: ``|E'| / |E|``, the share of its columns that the model does not span; the largest if it has several columns.
        prediction_error: [m], root mean square over random poses within the joint limits if the effect is present in its natural size; the largest
            if it has several coefficients.
        consequence: The same in words.
    """

    effect: Effect
    observability: float
    prediction_error: float
    consequence: str

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``.

        ``settings`` distinguishes effects with the same name and target, for example a backlash whose side follows from the moves or from the torque.
        """
        return {
            "name": self.effect.name,
            "target": self.effect.target,
            "settings": self.effect.to_mapping(),
            "observability": self.observability,
            "consequence": self.consequence,
        }


def unobservable_effects(
    state: FittedState, candidates: Sequence[Effect], bases: Bases | None = None
) -> list[Unobservable]:
    """Return the unobservable candidates, each with the prediction error that it would cause.

    Only kinds of which no effect was found are tested: candidates with a single term and a natural size, and those that would look like a compliance
    that was found (``ActsLikeCompliance``).

    Args:
        state: The fitted state.
        candidates: The candidates.
        bases: As for ``FittedState.columns_of``.
    """
    found_names = {effect.name for effect in state.effects}
    wanted = [
        effect
        for effect in candidates
        if effect.natural_sizes.any() and effect.n_terms == 1 and effect.name not in found_names
    ]
    E = state.columns_of(wanted, bases)
    background = state.background()
    left = E - background.Q @ (background.Q.T @ E)
    lengths_of_all, lengths_left = np.linalg.norm(E, axis=0), np.linalg.norm(left, axis=0)
    ends = np.cumsum([0, *(len(effect.coefficients) for effect in wanted)], dtype=int)
    result = []
    for effect, start, stop in zip(wanted, ends[:-1], ends[1:], strict=True):
        lengths = lengths_of_all[start:stop]
        acts = lengths > 0
        if not acts.any():
            continue
        share = float(np.max(lengths_left[start:stop][acts] / lengths[acts]))
        if share < state.settings.observability.unobservable:
            sizes = np.diag(effect.natural_sizes)
            errors = prediction_errors(state, effect, E[:, start:stop] @ sizes, sizes)
            which = int(np.argmax(errors))
            words = effect.consequence(float(errors[which]), which)
            result.append(Unobservable(effect, share, float(errors[which]), words))
    return [*result, *_beside_the_found(state, candidates)]


def _beside_the_found(state: FittedState, candidates: Sequence[Effect]) -> list[Unobservable]:
    """Return the candidates that may be present unseen beside an effect that was found, because they bear the same weight.

    Each is listed once, beside the place at which it may move the sensor farthest.

    Args:
        state: The fitted state.
        candidates: The candidates.
    """
    found_names = {effect.name for effect in state.effects}
    result = []
    for candidate in candidates:
        if not isinstance(candidate, ActsLikeCompliance) or candidate.name in found_names:
            continue
        pairs = [pair for effect in state.effects for pair in candidate.giving_way_like(effect)]
        alike = [_unseen_beside(state, candidate, *pair) for pair in pairs]
        result += sorted(filter(None, alike), key=lambda sized: -sized[0])[:1]
    return [entry for _, entry in result]


def _unseen_beside(
    state: FittedState, candidate: Effect, place: str, coefficients: Array
) -> tuple[float, Unobservable] | None:
    """Return how far a candidate may move the sensor unseen [m], root mean square, with its entry; None if only a small part stays unseen.

    It is seen if the squared residual that it leaves exceeds what the Bayesian information criterion asks for as many coefficients as are not zero.
    It is not assumed to be larger than the compliance that was found.

    Args:
        state: The fitted state.
        candidate: The candidate.
        place: The place that gives way by what was found.
        coefficients: ``(e,)``, those with which the candidate gives way as much as that place does.
    """
    background = state.background()
    column = state.columns_of([candidate]) @ coefficients
    left = float(np.linalg.norm(column - background.Q @ (background.Q.T @ column)))
    least = float(
        np.sqrt(background.variance * np.count_nonzero(coefficients) * np.log(background.degrees_of_freedom))
    )
    part = min(1.0, least / left) if left > 0 else 1.0
    if not column.any() or part < _LEAST_PART:
        return None
    part_of_it = part * coefficients
    moved = displacements(
        state, [candidate], np.r_[np.zeros(len(state.free)), part_of_it], random_poses(state)
    )
    size = float(np.sqrt(np.mean(moved**2)))
    (error,) = prediction_errors(state, candidate, part * column[:, None], part_of_it[:, None])
    share = left / float(np.linalg.norm(column))
    return size, Unobservable(candidate, share, float(error), consequence_beside(place, size, float(error)))


def prediction_errors(state: FittedState, effect: Effect, rows: Array, coefficients: Array) -> Array:
    """Return the prediction error ``(k,)`` [m] that each of k sizes of an effect causes if the model lacks it.

    It is the root mean square over random poses within the joint limits.

    Args:
        state: The fitted state, without the effect.
        effect: The effect, of e coefficients.
        rows: ``(N m, k)``, whitened: what each size adds to the rows.
        coefficients: ``(e, k)``, the coefficients of each.
    """
    J = whitened(state.whitening, state.linearised()[1])[: len(rows)]
    absorbed = np.linalg.lstsq(J, rows, rcond=_RANK_TOLERANCE)[0]
    poses = random_poses(state)
    errors = []
    for k in range(rows.shape[1]):
        steps = np.zeros(len(state.free) + len(coefficients))
        steps[: len(state.free)][state.free] = absorbed[:, k]
        steps[len(state.free) :] = -coefficients[:, k]
        errors.append(float(np.sqrt(np.mean(displacements(state, [effect], steps, poses) ** 2))))
    return np.array(errors)
