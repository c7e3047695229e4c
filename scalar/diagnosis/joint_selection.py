"""Joint selection: effects and variance components are fitted in one model, all at once.

Forward selection takes one effect after the other. Of several strong effects each explains a small share, the others look like a large scatter of
the poses, and with few poses no effect is significant beside that scatter. Here all candidates and the scatter are in one model
(``sparse_regression``); what is significant there is tested again effect by effect, as after forward selection.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import background_without, together
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.forward_selection import reconsidered, select_forward
from scalar.diagnosis.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.merging import merged
from scalar.diagnosis.score_test import Background, in_prior_units
from scalar.diagnosis.sparse_regression import sparse_regression
from scalar.diagnosis.variance_components import directions
from scalar.effects import Effect


def select_together(before: FittedState, forward: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the effects that are significant together, if it explains the data better than the one of forward selection.

    Nothing is tried where forward selection leaves no scatter of the poses, and with many poses, beside which every effect stands out alone.

    Args:
        before: Without effects.
        forward: Where forward selection ended.
        candidates: The candidate set of both.
    """
    if not forward.variance_components or before.dataset.n_poses > before.settings.joint_selection.most_poses:
        return forward
    found = [_with_all_significant(start, candidates) for start in (forward, before)]
    return max(found, key=lambda state: evidence_of(state, candidates))


def _with_all_significant(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return a state with the effects that are significant together given those that it has, as long as there are any."""
    settings = state.settings.selection
    for _ in range(state.settings.joint_selection.max_rounds):
        chosen = significant_together(state, candidates)
        if not chosen:
            break
        effects = state.effects
        for effect in chosen:
            effects = merged(effects, effect)
        trial = _weakest_dropped(state.refitted(effects), candidates)
        trial = select_forward(reconsidered(trial, candidates)[0], candidates)
        better = evidence_of(trial, candidates) - evidence_of(state, candidates)
        gain = improvement(held_out_errors(state, state.whitening), held_out_errors(trial, state.whitening))
        borne_out = gain >= settings.least_improvement and no_worse(
            held_out_errors(state), held_out_errors(trial)
        )
        if better <= settings.swap_margin or not borne_out:
            break
        state = trial
    return state


def significant_together(state: FittedState, candidates: CandidateSet) -> tuple[Effect, ...]:
    """Return the effects that are significant beside all other candidates and the scatter of the poses; of each, the terms that are.

    They have been picked from many, so they are no more than proposals: each is to be tested again.
    """
    settings, elements = state.settings.joint_selection, candidates.elements
    N, m = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
    some = np.unique(np.linspace(0, N - 1, min(N, settings.poses_at_once)).round().astype(int))
    rows = np.zeros((N, m), dtype=bool)
    rows[some] = True
    residual, jacobian = state.linearised()
    used = np.r_[rows.ravel(), np.ones(len(residual) - N * m, dtype=bool)]
    background = Background.of(residual[used], jacobian[used], len(some), m, state.settings.score_test)
    columns = state.columns_within_scans(elements, candidates.bases)[rows.ravel()]
    columns = columns * in_prior_units(
        background,
        np.sum(columns * columns, axis=0),
        np.concatenate([effect.prior_std for effect in elements]),
    )
    ends = np.cumsum([len(effect.coefficients) for effect in elements])
    groups = np.split(columns, ends[:-1], axis=1)
    common = [D[some] for _, D in directions(state.residuals, state.model)]
    found = sparse_regression(
        background.residual,
        background.Q,
        groups,
        common,
        settings.least_row_variance,
        state.settings.score_test.unobservable_share,
    )
    chances = chi2.sf(found.significance, found.widths) * len(groups)
    effects: tuple[Effect, ...] = ()
    most = background.residual.size / settings.rows_per_coefficient
    for k in np.argsort(-found.significance):
        if chances[k] > state.settings.selection.alpha_named_effect:
            continue
        more = merged(effects, elements[found.kept[k]])
        if sum(len(effect.coefficients) for effect in more) > most:
            break
        effects = more
    return effects


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
