"""Unobservable effects: the other parameters absorb them, so they leave no residual, but predictions at other poses may be wrong.

If an effect with coefficient c is present and not in the model, the fit moves the free parameters by ``J^+ E c``, with J and E the whitened columns
of the parameters and of the effect, and leaves the residual ``(I - J J^+) E c``. If that is almost zero, the effect is unobservable.
Its consequence is the difference between ``J^+ E c`` and the effect itself in the predicted positions, within the joint limits.

An effect may also be present unobserved together with one that was found, if the same weight causes both (``scalar.effects.same_weight``): where
joints are compliant, a compliant base looks like more or less of their compliance. It is listed with the largest size that would not be observed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.effect_columns import Bases
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.predicted_displacements import displacement_columns, random_poses
from scalar.effects import Effect
from scalar.effects.same_weight import ActsLikeCompliance, consequence_if_unobserved
from scalar.geometry.se3 import Array

# Chosen: an effect that would be observed if it were a smaller part of the compliance that was found is not listed.
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
        may_accompany: Whether it looks like an effect that was found, and may be present together with it.
    """

    effect: Effect
    observability: float
    prediction_error: float
    consequence: str
    may_accompany: bool = False

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
    left = _unexplained(background, E)
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
    return [*result, *_hidden_by_found_compliance(state, candidates, bases)]


def _unexplained(background: Background, columns: Array) -> Array:
    """Return the part of columns ``(N m,)`` or ``(N m, k)`` that the columns of a model do not span, in the same shape."""
    return columns - background.Q @ (background.Q.T @ columns)


def _hidden_by_found_compliance(
    state: FittedState, candidates: Sequence[Effect], bases: Bases | None
) -> list[Unobservable]:
    """Return the candidates that may be present unobserved because they look like a compliance that was found.

    Each is listed once: as a part of the compliance of that place, among those that were found, where it may move the sensor farthest.

    Args:
        state: The fitted state.
        candidates: The candidates.
        bases: As for ``FittedState.columns_of``.
    """
    found_names = {effect.name for effect in state.effects}
    background, result = state.background(), []
    for candidate in candidates:
        if not isinstance(candidate, ActsLikeCompliance) or candidate.name in found_names:
            continue
        E = state.columns_of([candidate], bases)
        hidden = [
            (place, part, coefficients)
            for effect in state.effects
            for place, coefficients in candidate.giving_way_like(effect)
            if (part := _unobserved_part(background, E @ coefficients, coefficients)) >= _LEAST_PART
        ]
        if not hidden:
            continue
        columns = displacement_columns(state, random_poses(state), [candidate])
        no_steps = np.zeros(len(state.free))
        sizes = [_moved(columns, np.r_[no_steps, part * c]) for _, part, c in hidden]
        place, part, coefficients = hidden[int(np.argmax(sizes))]
        rows = E @ coefficients
        share = float(np.linalg.norm(_unexplained(background, rows)) / np.linalg.norm(rows))
        (error,) = prediction_errors(state, candidate, part * rows[:, None], part * coefficients[:, None])
        words = consequence_if_unobserved(place, max(sizes), float(error))
        result.append(Unobservable(candidate, share, float(error), words, may_accompany=True))
    return result


def _unobserved_part(background: Background, rows: Array, coefficients: Array) -> float:
    """Return the largest part of an effect, at most 1, that is not observed; 0 if the effect does not act.

    A part is observed if the squared residual that it leaves exceeds what the Bayesian information criterion requires for as many coefficients as are
    not zero.

    Args:
        background: Of the model without the effect.
        rows: ``(N m,)``, whitened: what the effect adds to the rows.
        coefficients: ``(e,)``, those of the effect.
    """
    if not rows.any():
        return 0.0
    left = float(np.linalg.norm(_unexplained(background, rows)))
    least = background.variance * np.count_nonzero(coefficients) * np.log(background.degrees_of_freedom)
    return min(1.0, float(np.sqrt(least)) / left) if left > 0 else 1.0


def _moved(columns: Array, steps: Array) -> float:
    """Return how far predicted positions move [m], root mean square over K poses.

    Args:
        columns: ``(3 K, P)``, derivatives of the positions, as ``displacement_columns`` returns them.
        steps: ``(P,)``, steps of the parameters and coefficients.
    """
    return float(np.sqrt(np.mean(np.linalg.norm((columns @ steps).reshape(-1, 3), axis=1) ** 2)))


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
    columns, errors = displacement_columns(state, random_poses(state), [effect]), []
    for k in range(rows.shape[1]):
        steps = np.zeros(len(state.free) + len(coefficients))
        steps[: len(state.free)][state.free] = absorbed[:, k]
        steps[len(state.free) :] = -coefficients[:, k]
        errors.append(_moved(columns, steps))
    return np.array(errors)
