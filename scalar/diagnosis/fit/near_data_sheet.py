"""Keep the final fits of a diagnosis near the data sheet in the directions that the poses hardly determine, and flexible terms small.

Effects are selected without these priors. A large misfit gives the priors much weight, and they would then keep the geometry from adapting to the
effect that causes the misfit. Once the effects are known, the priors are weighted by the remaining residual, as in a calibration.
"""

from __future__ import annotations

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.estimation.data_sheet_priors import fit_near_data_sheet


def near_data_sheet(state: FittedState) -> FittedState:
    """Return the optimum with the same effects and the priors of final fits; the same state if these priors make no difference."""
    if state.is_rounding:
        return state
    effects = [effect.for_final_fit() for effect in state.effects]
    if any(new is not old for new, old in zip(effects, state.effects, strict=True)):
        state = state.refitted(effects)
    model = fit_near_data_sheet(
        state.residuals, state.model, state.free, state.settings.estimation, near_optimum=True
    )
    if not model.priors:
        return state
    return refit(state.dataset, model, state.geometry_free, model.effects, state.settings, state.rows)
