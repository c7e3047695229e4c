"""Hold a diagnosis' final fits near the data sheet in the directions that the poses hardly determine.

Effects are selected without such priors, since a misfit that makes them tight would hold the geometry against the very effect that is looked for.
Once the effects are known, what they leave weighs the priors, as in a calibration.
"""

from __future__ import annotations

from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.estimation.data_sheet_priors import fit_near_data_sheet


def near_data_sheet(state: FittedState) -> FittedState:
    """Return the optimum with priors of the data sheet, the effects kept; the same state where the priors make no difference."""
    if state.is_rounding:
        return state
    model = fit_near_data_sheet(state.residuals, state.model, state.free, state.settings.estimation)
    if not model.priors:
        return state
    return refit(state.dataset, model, state.geometry_free, model.effects, state.settings, state.rows)
