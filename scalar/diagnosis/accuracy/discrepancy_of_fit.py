"""What the model of a calibration may lack, as its data tell: an excess of the residual, hidden effects and possible effects.

Every stated error over the workspace counts the same three: those in the report, in the table of a fleet and in ``diagnosis.json``.
"""

from __future__ import annotations

from scalar.diagnosis.accuracy.excess_residual import Shipping, excess_distance, excess_distance_after
from scalar.diagnosis.accuracy.hidden_effects import hidden_effects
from scalar.diagnosis.accuracy.possible_effects import possible_effects
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.estimation.result import Calibration
from scalar.evaluate.model_discrepancy import ModelDiscrepancy


def discrepancy_of_calibration(calibration: Calibration, state: FittedState) -> ModelDiscrepancy:
    """Return what the model of a calibration may lack.

    Args:
        calibration: The calibration.
        state: Its model and data, at its optimum.
    """
    return _discrepancy(state, excess_distance(calibration, state))


def discrepancy_of_shipped(diagnosis: Shipping) -> ModelDiscrepancy:
    """Return what the model of ``after.json`` may lack."""
    return _discrepancy(diagnosis.shipped_state, excess_distance_after(diagnosis))


def _discrepancy(state: FittedState, excess: float) -> ModelDiscrepancy:
    """Return what a fit may lack, with the root mean square distance ``excess`` [m] by which poses are off beyond the noise."""
    possible = possible_effects(state).draws
    hidden = hidden_effects(state)
    if hidden is None:
        return ModelDiscrepancy(excess, possible=possible)
    return ModelDiscrepancy(excess, hidden.deviations, hidden.kinds, possible)
