"""The log evidence of a whole fitted state, by which models with different sets of effects are compared."""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateSet


def evidence_of(state: FittedState, candidates: CandidateSet) -> float:
    """Return the log evidence of a state [nats]: its log likelihood, penalised for coefficients and for the choice among the candidates.

    It is defined up to a constant that depends on the data only. The likelihood is that of the noise within scans, with the gain of the state's
    likeliest variance component added. The penalty of a coefficient is that of the Bayesian information criterion. Each part of an effect (a joint,
    an order) was chosen among the candidates, as in ``subset_search``.
    """
    background = state.background_within_scans()
    n_rows = background.residual.size
    fit = (
        -0.5 * background.sum_of_squares * background.n_live / background.degrees_of_freedom
        - n_rows * np.log(state.residuals.measurement.sigma)
    )
    gain_of_component = max((c.log_likelihood_gain for c in state.variance_components), default=0.0)
    n_coefficients = sum(len(effect.coefficients) for effect in state.effects)
    cost_of_choice = sum(len(effect.parts()) for effect in state.effects) * np.log(candidates.total)
    return float(
        fit
        + gain_of_component
        - 0.5 * n_coefficients * np.log(background.degrees_of_freedom)
        - cost_of_choice
    )
