"""Joint selection: effects and variance components are fitted in one model, all at once.

Forward selection takes one effect after the other. Of several strong effects each explains a small share, the others look like a large scatter of
the poses, and with few poses no effect is significant beside that scatter. Here all candidates and the scatter are in one model
(``sparse_regression``); what is significant there is tested again effect by effect, as after forward selection.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import background_without, together
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.forward_selection import reconsidered, select_forward
from scalar.diagnosis.hold_out import blocks, held_out_errors, improvement, no_worse
from scalar.diagnosis.merging import merged
from scalar.diagnosis.score_test import Background, in_prior_units
from scalar.diagnosis.sparse_regression import sparse_regression
from scalar.diagnosis.variance_components import directions
from scalar.effects import Effect
from scalar.geometry.se3 import Array


def select_together(before: FittedState, forward: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the effects that are significant together, if it explains the data better than the one of forward selection.

    Nothing is tried where forward selection leaves no scatter of the poses, and with many poses, beside which every effect stands out alone.

    Args:
        before: Without effects.
        forward: Where forward selection ended.
        candidates: The candidate set of both.
    """
    settings = before.settings.joint_selection
    few = before.dataset.n_poses <= settings.most_poses
    if not (few and forward.variance_components and candidates.elements):
        return forward
    anew = _with_significant(before, candidates)
    state = forward if anew is None else _better(forward, anew, candidates)
    while True:  # each round has clearly more evidence than the one before
        more = _with_significant(state, candidates)
        if more is None or _better(state, more, candidates) is state:
            return state
        state = more


def _with_significant(state: FittedState, candidates: CandidateSet) -> FittedState | None:
    """Return a state with the effects that are significant together given those that it has, each tested again, or None if there are none."""
    chosen = significant_together(state, candidates)
    if not chosen:
        return None
    effects = state.effects
    for effect in chosen:
        effects = merged(effects, effect)
    trial = _weakest_dropped(state.refitted(effects), candidates)
    return select_forward(reconsidered(trial, candidates)[0], candidates)


def _better(state: FittedState, trial: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the trial if it has clearly more evidence and predicts held-out poses clearly better, else the state."""
    settings = state.settings.selection
    if evidence_of(trial, candidates) <= evidence_of(state, candidates) + settings.swap_margin:
        return state
    gain = improvement(held_out_errors(state, state.whitening), held_out_errors(trial, state.whitening))
    if gain < settings.least_improvement or not no_worse(held_out_errors(state), held_out_errors(trial)):
        return state
    return trial


def significant_together(state: FittedState, candidates: CandidateSet) -> tuple[Effect, ...]:
    """Return the effects that are significant beside all other candidates and the scatter of the poses; of each, the terms that are.

    They have been picked from many, and with few poses some of so many candidates imitate any scatter. Such ones change with the poses, so
    an effect has to be significant without each of most parts of the poses as well (stability selection: Meinshausen and Buehlmann, Journal of the
    Royal Statistical Society B 72, 2010). What is returned is still no more than a proposal: each effect is to be tested again.
    """
    settings, elements = state.settings.joint_selection, candidates.elements
    N = state.dataset.n_poses
    some = np.unique(np.linspace(0, N - 1, min(N, settings.poses_at_once)).round().astype(int))
    everything = _Rows.of(state, candidates)
    fold = blocks(state.dataset.q, state.settings.hold_out)[1]
    significance = everything.significance(some)
    stable = np.zeros(len(elements))
    for f in np.unique(fold[some]):
        stable += everything.significance(some[fold[some] != f]) > 0
    wanted = settings.stable * len(np.unique(fold[some]))
    effects: tuple[Effect, ...] = ()
    most = everything.rows_per_pose * len(some) / settings.rows_per_coefficient
    for k in np.argsort(-significance):
        if significance[k] == 0:
            break
        if stable[k] < wanted:
            continue
        more = merged(effects, elements[k])
        if sum(len(effect.coefficients) for effect in more) > most:
            break
        effects = more
    return effects


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of a state and the columns of all candidates.

    Attributes:
        state: Fitted.
        columns: ``(N m, e)``, whitened within scans. ends: ``(K,)``, where the columns of each element end.
        prior_std: ``(e,)``, of their coefficients. common: Directions in which all rows of a pose err together.
    """

    state: FittedState
    columns: Array
    ends: Array
    prior_std: Array
    common: list[Array]

    @classmethod
    def of(cls, state: FittedState, candidates: CandidateSet) -> _Rows:
        elements = candidates.elements
        columns = state.columns_within_scans(elements, candidates.bases)
        ends = np.cumsum([len(effect.coefficients) for effect in elements])
        prior_std = np.concatenate([np.zeros(0), *(effect.prior_std for effect in elements)])
        common = [D for _, D in directions(state.residuals, state.model)]
        return cls(state, columns, ends, prior_std, common)

    @property
    def rows_per_pose(self) -> int:
        return self.state.residuals.measurement.rows_per_pose

    def significance(self, poses: Array) -> Array:
        """Return the significance ``(K,)`` of every element by some of the poses, zero where it is none."""
        N, m, settings = self.state.dataset.n_poses, self.rows_per_pose, self.state.settings
        rows = (poses[:, None] * m + np.arange(m)).ravel()
        residual, jacobian = self.state.linearised()
        used = np.r_[rows, np.arange(N * m, len(residual))]
        background = Background.of(residual[used], jacobian[used], len(poses), m, settings.score_test)
        columns = self.columns[rows]
        columns = columns * in_prior_units(background, np.sum(columns * columns, axis=0), self.prior_std)
        groups = np.split(columns, self.ends[:-1], axis=1)
        found = sparse_regression(
            background.residual,
            background.Q,
            groups,
            [D[poses] for D in self.common],
            settings.joint_selection.least_row_variance,
            settings.score_test.unobservable_share,
        )
        chances = chi2.sf(found.significance, found.widths) * len(groups)
        significant = chances <= settings.selection.alpha_named_effect
        result = np.zeros(len(groups))
        result[found.kept[significant]] = found.significance[significant]
        return result


def _weakest_dropped(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return a state whose effects are all significant given the others; the least significant one is dropped first."""
    while state.effects:
        each = range(len(state.effects))
        scores = [together(state, [i], candidates, background_without(state, [i])) for i in each]
        weakest = min(each, key=lambda i: scores[i].evidence)
        own = scores[weakest]
        if own.evidence > 0 and own.p_value <= state.settings.selection.alpha_named_effect:
            break
        state = state.refitted([effect for i, effect in enumerate(state.effects) if i != weakest])
    return state


def evidence_of(state: FittedState, candidates: CandidateSet) -> float:
    """Return the log likelihood of a state with its variance component, less what its coefficients and the choice of its effects cost [nats]."""
    background, n = state.background_within_scans(), state.background_within_scans().residual.size
    live = background.freedom + background.Q.shape[1]
    fit = -0.5 * background.squared * live / background.freedom - n * np.log(
        state.residuals.measurement.sigma
    )
    scatter = max((c.log_likelihood_gain for c in state.variance_components), default=0.0)
    coefficients = sum(len(effect.coefficients) for effect in state.effects)
    choice = len(state.effects) * np.log(candidates.total)
    return float(fit + scatter - 0.5 * coefficients * np.log(background.freedom) - choice)
