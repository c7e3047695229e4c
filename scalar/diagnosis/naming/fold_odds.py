"""The log odds of an effect against its rivals when one fold of the poses is left out.

If the odds fall far when one fold is left out, the answer depends on a few poses only. A *rival* is a candidate that might explain the data in the
effect's place. The odds compare the fit and the number of coefficients: no penalty for the number of candidates is subtracted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.held_out.hold_out import blocks_of
from scalar.diagnosis.scoring.conditional_scores import columns_of_effects, parts_of, without_columns
from scalar.diagnosis.scoring.score_test import Projected, evidence
from scalar.effects import Effect
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class WithoutFold:
    """The poses of a state that remain when one fold is left out.

    Attributes:
        state: The fitted state, with all poses.
        rows: ``(n,)``, the indices of the remaining rows.
        background: Of the state's model on these rows, whitened for the state's variance component.
    """

    state: FittedState
    rows: Array
    background: Background

    def evidences(self, removed: Array, E: Array, prior_std: Array, groups: Sequence[Array]) -> list[float]:
        """Return the log evidence [nats] of each group of columns given the model without some of its columns; zero where it is negative.

        A group with negative evidence explains less than no effect at all, and is counted as no effect.

        Args:
            removed: ``(F,)`` bool, the k columns of the model that are left out.
            E: ``(n, e)``, the columns that are scored; the first k are those that are left out.
            prior_std: ``(e,)``, prior standard deviations of their coefficients.
            groups: The indices of the columns of each group.
        """
        background = without_columns(self.background, self.state, removed)
        projected = Projected.of(background, E, E.T @ E, prior_std)
        found = []
        for group in groups:
            gain, dof, _ = projected.score(group[None])
            found.append(max(float(evidence(background, gain, dof, np.zeros(1))[0]), 0.0))
        return found


def without_each_fold(state: FittedState) -> list[WithoutFold]:
    """Return the poses of a state without each of its folds."""
    residual, jacobian = (whitened(state.whitening, rows) for rows in state.linearised())
    m, settings = state.residuals.measurement.rows_per_pose, state.settings.score_test
    fold = blocks_of(state)[1]
    found = []
    for f in np.unique(fold):
        rows, used = state.rows_of(np.flatnonzero(fold != f))
        background = Background.of(residual[used], jacobian[used], len(rows) // m, m, settings)
        found.append(WithoutFold(state, rows, background))
    return found


def fold_odds(i: int, others: Sequence[Effect], folds: Sequence[WithoutFold]) -> Array:
    """Return the least log odds of an effect over the folds of poses, one fold left out at a time [nats].

    Args:
        i: Index of the effect in ``state.effects`` of the fitted state.
        others: The K rivals, which are not in the state.
        folds: What ``without_each_fold`` returns for the state.

    Returns:
        ``(1 + K,)`` [nats]: first the log odds against no effect, then those against each rival in the effect's place. Each number is the least over
        the folds. If the effect has several joints or orders, the first number is the least of the log odds of the whole effect and those of each
        joint or order given the others.
    """
    state = folds[0].state
    of_effect, prior_std = columns_of_effects(state, [i])
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    own_columns = whitened(state.whitening, state.linearised()[1][:measured, of_effect])
    E = np.column_stack([own_columns, state.columns_of(others)])
    prior_std = np.concatenate([prior_std, *(effect.prior_std for effect in others)])
    ends = np.cumsum([int(of_effect.sum()), *(len(effect.coefficients) for effect in others)])
    groups = np.split(np.arange(E.shape[1]), ends[:-1])
    parts = parts_of(state, i)
    odds_by_fold = []
    for remaining in folds:
        columns = E[remaining.rows]
        own, *rivals = remaining.evidences(of_effect, columns, prior_std, groups)
        of_parts = [remaining.evidences(part, columns[:, np.flatnonzero(part[of_effect])], part_prior_std, [np.arange(part.sum())])[0]
                   for part, part_prior_std in parts]  # fmt: skip
        odds_by_fold.append([min([own, *of_parts]), *(own - rival for rival in rivals)])
    return np.min(odds_by_fold, axis=0)
