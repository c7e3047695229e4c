"""Joint selection: the set of effects that explains the data best as a whole, tested effect by effect.

Forward selection takes one effect after the other. Of several strong effects each explains a small share, the others look like a large scatter of
the poses, and with few poses no effect is significant beside that scatter; or several wrong effects imitate a right one bit by bit. Here whole
sets are compared (``subset_search``). What is found is tested again effect by effect, as after forward selection, and takes its place if it has
clearly more evidence and predicts held-out poses clearly better.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.backward_elimination import borne_out
from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import background_without, together
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.forward_selection import reconsidered, select_forward
from scalar.diagnosis.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.subset_search import best_subset

SEARCHES = 2  # each about the optimum of the one before: effects that are large are not linear about a model without them


def select_together(before: FittedState, forward: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the set of effects that explains most, if it explains the data better than the one of forward selection.

    With many poses nothing is tried: beside these every effect stands out alone.

    Args:
        before: Without effects.
        forward: Where forward selection ended.
        candidates: The candidate set of both.
    """
    if before.is_rounding or before.dataset.n_poses > before.settings.subset_search.most_poses:
        return forward
    state = before
    for _ in range(SEARCHES):
        effects = best_subset(state, candidates)
        if not effects:
            return borne_out(forward)
        state = before.refitted(effects, state.model)
    tested = borne_out(reconsidered(_weakest_dropped(state, candidates), candidates)[0])
    return borne_out(_better(forward, select_forward(tested, candidates), candidates))


def _better(state: FittedState, trial: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the trial if it has clearly more evidence and predicts held-out poses clearly better, else the state."""
    settings = state.settings.selection
    if (
        not trial.is_plausible
        or evidence_of(trial, candidates) <= evidence_of(state, candidates) + settings.swap_margin
    ):
        return state
    gain = improvement(held_out_errors(state, state.whitening), held_out_errors(trial, state.whitening))
    if gain < settings.least_improvement or not no_worse(held_out_errors(state), held_out_errors(trial)):
        return state
    return trial


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
