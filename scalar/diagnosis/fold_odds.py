"""How an effect does against its rivals when some poses are left out: an answer that hangs on a few poses is a doubtful one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.conditional_scores import columns_of_effects
from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.diagnosis.hold_out import blocks
from scalar.diagnosis.score_test import Background, Projected, evidence
from scalar.effects import Effect
from scalar.geometry.se3 import Array


def fold_odds(state: FittedState, i: int, others: Sequence[Effect]) -> Array:
    """Return the least log odds of an effect over the folds of poses, one fold left out at a time [nats].

    Args:
        state: With the effect.
        i: Which of its effects.
        others: K rivals.

    Returns:
        ``(1 + K,)``: against nothing, which is that of its weakest part where it has several joints or orders, and against each rival in its place.
    """
    residual, jacobian = (whitened(state.whitening, rows) for rows in state.linearised())
    mine, sizes = columns_of_effects(state, [i])
    N, m = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
    E = np.column_stack([jacobian[: N * m, mine], state.columns_of(others)])
    sizes = np.concatenate([sizes, *(effect.prior_std for effect in others)])
    ends = np.cumsum([int(mine.sum()), *(len(effect.coefficients) for effect in others)])
    groups = np.split(np.arange(E.shape[1]), ends[:-1])
    fold = blocks(state.dataset.q, state.settings.hold_out)[1]
    parts = _parts(state, i, mine)
    found = []
    for f in np.unique(fold):
        rows, used = state.rows_of(np.flatnonzero(fold != f))
        fewer = _Fold(state, residual[used], jacobian[used], len(rows) // m)
        own, *rivals = fewer.evidences(mine, E[rows], sizes, groups)
        weakest = [fewer.evidences(part, jacobian[rows][:, part], its_sizes, [np.arange(part.sum())])[0]
                   for part, its_sizes in parts]  # fmt: skip
        found.append([min([own, *weakest]), *(own - rival for rival in rivals)])
    return np.min(found, axis=0)


def _parts(state: FittedState, i: int, mine: Array) -> list[tuple[Array, Array]]:
    """Return which free columns ``(F,)`` belong to each part of an effect, and their prior standard deviations; nothing where it has one part."""
    effect = state.effects[i]
    parts = effect.parts()
    where = np.flatnonzero(mine)
    if len(parts) == 1 or len(where) != len(effect.coefficients):
        return []
    width = len(effect.coefficients) // effect.n_terms
    found = []
    for terms in parts:
        columns = np.concatenate([np.arange(k * width, (k + 1) * width) for k in terms])
        part = np.zeros(len(mine), dtype=bool)
        part[where[columns]] = True
        found.append((part, effect.prior_std[columns]))
    return found


@dataclass(frozen=True, eq=False)
class _Fold:
    """The rows of the poses that are left, priors included."""

    state: FittedState
    residual: Array
    jacobian: Array
    n_poses: int

    def evidences(self, mine: Array, E: Array, sizes: Array, groups: Sequence[Array]) -> list[float]:
        """Return the evidence of groups of columns E ``(N m, e)`` where the columns ``mine`` ``(F,)`` of the model are left out, zero at least."""
        state = self.state
        without = self.residual - self.jacobian[:, mine] @ state.model.vector[state.free][mine]
        m, settings = state.residuals.measurement.rows_per_pose, state.settings.score_test
        background = Background.of(without, self.jacobian[:, ~mine], self.n_poses, m, settings)
        projected = Projected.of(background, E, E.T @ E, sizes)
        found = []
        for group in groups:
            gain, dof, _ = projected.score(group[None])
            found.append(max(float(evidence(background, gain, dof, np.zeros(1))[0]), 0.0))
        return found
