"""Stability selection: the effects that the lasso takes in most halves of the poses (Meinshausen and Bühlmann, 2010).

In each half the penalty falls until ``q`` columns have entered, with q from the bound on the expected number of false selections,
``E(V) <= q^2 / ((2 pi - 1) p)`` for p columns and the threshold pi. An effect is selected with any of its columns. Like the lasso it has no
columns for changes at a moment.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.diagnosis.rivals import LEAST_SHARE, descend, entries
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.scoring.merging import merged
from scalar.effects import Effect
from scalar.geometry.se3 import Array

HALVES, THRESHOLD, FALSE_ONES = 40, 0.75, 1.0  # draws, pi, and the bound on E(V)
FALL, LEAST_PENALTY = 0.93, 1e-3  # of the penalty from step to step; the last as a share of the first
TOLERANCE = 1e-6  # of coordinate descent, in units of the largest correlation


def chosen_by_stability(before: FittedState, rng: np.random.Generator) -> tuple[Effect, ...]:
    """Return the effects that are selected in at least ``THRESHOLD`` of the halves, the most frequent first."""
    elements = named_candidates(before.dataset).elements
    owner = np.concatenate([np.full(len(e.coefficients), i) for i, e in enumerate(elements)])
    k = len(owner)
    poses, per_pose = before.background().residual.shape
    rows = before.columns_of(elements).reshape(poses, per_pose, k)
    residual, jacobian = before.linearised()
    J = jacobian[: poses * per_pose].reshape(poses, per_pose, -1)
    r = residual[: poses * per_pose].reshape(poses, per_pose)
    often = np.zeros(len(elements))
    for _ in range(HALVES // 2):
        order = rng.permutation(poses)
        for half in (order[: poses // 2], order[poses // 2 :]):
            parts = (rows[half].reshape(-1, k), J[half].reshape(-1, J.shape[-1]), r[half].ravel())
            often[np.unique(owner[first_columns(*parts)])] += 1.0 / HALVES
    chosen: tuple[Effect, ...] = ()
    for i in np.argsort(-often, kind="stable"):
        if often[i] < THRESHOLD:
            break
        chosen = merged(chosen, elements[i])
    return chosen


def stability(before: FittedState, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return the same as entries of ``diagnosis.json``."""
    return entries(chosen_by_stability(before, rng))


def first_columns(E: Array, J: Array, r: Array) -> Array:
    """Return the indices of the columns that enter the lasso first, as many as the bound allows.

    Args:
        E: ``(M, k)``, of the candidates. J: ``(M, F)``, of the model, projected out of E and r. r: ``(M,)``, the residual.
    """
    scale = np.linalg.norm(J, axis=0)
    Q = np.linalg.qr(J / np.where(scale > 0, scale, 1.0))[0]
    left = E - Q @ (Q.T @ E)
    own = np.einsum("mk,mk->k", left, left)
    seen = np.flatnonzero(own > LEAST_SHARE * np.einsum("mk,mk->k", E, E))
    A = left[:, seen] / np.sqrt(own[seen])
    most = max(int(np.sqrt((2 * THRESHOLD - 1) * len(seen) * FALSE_ONES)), 1)
    correlation = A.T @ (r - Q @ (Q.T @ r))
    top = float(np.abs(correlation).max(initial=0.0))
    w, products, active = np.zeros(len(seen)), {}, np.zeros(0, dtype=int)
    penalty = top
    while penalty > LEAST_PENALTY * top and len(active) < most:
        penalty *= FALL
        gradient = correlation.copy()
        for j in active:
            gradient -= products[j] * w[j]
        while True:
            fresh = np.setdiff1d(np.flatnonzero(np.abs(gradient) > penalty * (1 + TOLERANCE)), active)
            for j in fresh:
                products[int(j)] = A.T @ A[:, j]
            active = np.union1d(active, fresh)
            descend(w, gradient, active, products, penalty, TOLERANCE * top)
            if not len(fresh):
                break
        active = active[w[active] != 0]
    return seen[active[np.argsort(-np.abs(w[active]), kind="stable")][:most]]
