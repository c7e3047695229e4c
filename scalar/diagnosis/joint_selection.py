"""Joint selection: the set of effects that explains the data best as a whole, tested effect by effect.

Forward selection adds one effect after the other. This fails in two ways. If several strong effects are present, each of them explains a small
share of the residual, while the others look like a large scatter of the poses; with few poses no effect is significant against that scatter. Or
several wrong effects, added one by one, together mimic a right one. Here whole sets are compared (``subset_search``). Each effect of the set that
is found is tested given the others, as after forward selection. The set replaces the result of forward selection if it has clearly more
evidence and predicts held-out poses clearly better.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.backward_elimination import eliminate_backward
from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import background_without, score_together
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.forward_selection import reconsidered, select_forward
from scalar.diagnosis.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.subset_search import best_subset

SEARCHES = 2  # the second is linearised at the optimum that the first one found: large effects are not linear about a model without them


def select_jointly(before: FittedState, forward: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the set of effects that explains most, if it explains the data better than the one of forward selection.

    With many poses no sets are searched, because every effect is then significant alone.

    Args:
        before: The state without effects.
        forward: The state that forward selection found.
        candidates: The candidate set.
    """
    if before.is_rounding or before.dataset.n_poses > before.settings.subset_search.most_poses:
        return forward
    state = before
    for _ in range(SEARCHES):
        effects = best_subset(state, candidates)
        if not effects:
            return eliminate_backward(forward)
        state = before.refitted(effects, state.model)
    tested = eliminate_backward(reconsidered(_weakest_dropped(state, candidates), candidates)[0])
    return eliminate_backward(_better(forward, select_forward(tested, candidates), candidates))


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
        scores = [score_together(state, [i], candidates, background_without(state, [i])) for i in each]
        weakest = min(each, key=lambda i: scores[i].evidence)
        own = scores[weakest]
        if own.evidence > 0 and own.p_value <= state.settings.selection.alpha_named_effect:
            break
        state = state.refitted([effect for i, effect in enumerate(state.effects) if i != weakest])
    return state


def evidence_of(state: FittedState, candidates: CandidateSet) -> float:
    """Return the log evidence of a state [nats]: its log likelihood, penalised for coefficients and for the choice among the candidates.

    The likelihood includes the state's likeliest variance component. The penalty of a coefficient is that of the Bayesian information criterion.
    """
    background, n = state.background_within_scans(), state.background_within_scans().residual.size
    live = background.freedom + background.Q.shape[1]
    fit = -0.5 * background.squared * live / background.freedom - n * np.log(
        state.residuals.measurement.sigma
    )
    scatter = max((c.log_likelihood_gain for c in state.variance_components), default=0.0)
    coefficients = sum(len(effect.coefficients) for effect in state.effects)
    choice = len(state.effects) * np.log(candidates.total)
    return float(fit + scatter - 0.5 * coefficients * np.log(background.freedom) - choice)
