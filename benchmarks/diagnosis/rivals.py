"""Rivals of the diagnosis: textbook methods of selection, on the same candidate columns and the same fitted model without effects.

``stepwise`` is orthogonal least squares (Chen, Billings and Luo, 1989): the candidate of greatest evidence is added and all is refitted, until
no candidate lowers the Bayesian information criterion. ``lasso`` (Tibshirani, 1996) shrinks the coefficients of all columns together; the
penalty is the one of least BIC, nonzero coefficients being counted. Neither holds poses out, lists what is confounded, or can say that it
does not know. The lasso has no columns for changes at a moment, since there would be as many as poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, named_candidates
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import rank
from scalar.diagnosis.scoring.score_test import gram_given
from scalar.effects import Effect
from scalar.geometry.se3 import Array

MOST_EFFECTS = 10
LEAST_SHARE = 1e-3
"""Least share of a column's squared length that the model does not explain; with less, the column is mostly rounding errors."""
PENALTIES, LEAST_PENALTY = 60, 1e-3
"""Number of penalties on the path, and the last of them as a share of the one at which the first column enters."""
PATIENCE = 10
"""Steps of the path without a lower criterion, after which it ends."""
ROUNDS, SWEEPS, TOLERANCE = 20, 300, 1e-5
"""Of coordinate descent; the tolerance in units of the largest correlation."""


def stepwise(before: FittedState) -> list[dict[str, Any]]:
    """Return what ``chosen_by_steps`` does as entries of ``diagnosis.json``."""
    return entries(chosen_by_steps(before))


def chosen_by_steps(before: FittedState) -> tuple[Effect, ...]:
    """Return the effects that forward selection by BIC adds to a state without effects."""
    tried, state = named_candidates(before.dataset), before
    for _ in range(MOST_EFFECTS):
        best = rank(state, state.background(), CandidateColumns(state, tried))[0]
        if best.evidence <= 0:
            break
        state = state.refitted(merged(state.effects, best.effect))
    return state.effects


def lasso(before: FittedState) -> list[dict[str, Any]]:
    """Return what ``chosen_by_lasso`` does as entries of ``diagnosis.json``."""
    return entries(chosen_by_lasso(before))


def chosen_by_lasso(before: FittedState) -> tuple[Effect, ...]:
    """Return the effects whose columns the lasso selects, those of the largest coefficient first."""
    elements, full = named_candidates(before.dataset).elements, before.background()
    owner = np.concatenate([np.full(len(e.coefficients), i) for i, e in enumerate(elements)])
    E = before.columns_of(elements)
    own_gram = E.T @ E
    given = gram_given(full, E, own_gram)
    own = np.diag(given)
    seen = own > LEAST_SHARE * np.diag(own_gram)
    scale = np.sqrt(own[seen])
    gram = given[np.ix_(seen, seen)] / np.outer(scale, scale)
    correlation = (E.T @ full.residual.ravel())[seen] / scale
    weights = least_bic(gram, correlation, full.sum_of_squares, full.degrees_of_freedom)
    size = np.zeros(len(elements))
    np.maximum.at(size, owner[seen], np.abs(weights))
    chosen: tuple[Effect, ...] = ()
    for i in np.argsort(-size, kind="stable")[: np.count_nonzero(size)]:
        chosen = merged(chosen, elements[i])
    return chosen


def least_bic(gram: Array, correlation: Array, sum_of_squares: float, degrees_of_freedom: int) -> Array:
    """Return the lasso's coefficients ``(k,)`` of least BIC on a path of penalties.

    Args:
        gram: ``(k, k)`` of columns of unit length. correlation: ``(k,)``, their products with the residual.
        sum_of_squares: Of the residual.
        degrees_of_freedom: Of the residual.
    """
    w = np.zeros(len(correlation))
    if not len(w):
        return w
    top = float(np.abs(correlation).max())
    best, least, since = w, degrees_of_freedom * np.log(sum_of_squares), 0
    for penalty in top * np.geomspace(1.0, LEAST_PENALTY, PENALTIES):
        w = descended(gram, correlation, w, penalty, TOLERANCE * top)
        left = sum_of_squares - 2.0 * w @ correlation + w @ gram @ w
        criterion = degrees_of_freedom * np.log(max(left, 1e-300)) + np.count_nonzero(w) * np.log(
            degrees_of_freedom
        )
        best, least, since = (w, criterion, 0) if criterion < least else (best, least, since + 1)
        if since == PATIENCE:
            break
    return best


def descended(gram: Array, correlation: Array, start: Array, penalty: float, tolerance: float) -> Array:
    """Return the minimum of ``w G w / 2 - c w + penalty |w|_1`` by coordinate descent over the columns that are not at rest at zero."""
    w = start.copy()
    gradient = correlation - gram @ w
    for _ in range(ROUNDS):
        active = np.flatnonzero((w != 0) | (np.abs(gradient) > penalty + tolerance))
        moved = descend(w, gradient, active, gram, penalty, tolerance)
        if moved <= tolerance and not np.any((w == 0) & (np.abs(gradient) > penalty + tolerance)):
            break
    return w


def descend(
    w: Array,
    gradient: Array,
    active: Array,
    columns: Array | dict[int, Array],
    penalty: float,
    tolerance: float,
) -> float:
    """Move the active coefficients to the lasso's minimum and the gradient ``c - G w`` with them, in place; return the last sweep's largest step.

    Args:
        w, gradient: ``(k,)``. active: Indices. columns: Of G, by index. penalty: Of the lasso. tolerance: Of the steps.
    """
    moved = 0.0
    for _ in range(SWEEPS):
        moved = 0.0
        for j in active:
            own = columns[j]
            z = gradient[j] + own[j] * w[j]
            step = float(np.sign(z) * max(abs(z) - penalty, 0.0) / own[j] - w[j])
            if step:
                w[j] += step
                gradient -= own * step
                moved = max(moved, abs(step))
        if moved <= tolerance:
            break
    return moved


def entries(effects: Sequence[Effect]) -> list[dict[str, Any]]:
    """Return effects as entries of ``diagnosis.json``, in their order; the rivals do not look for confounded effects."""
    return [{"name": e.name, "target": e.target, "confounded_with": []} for e in effects]
