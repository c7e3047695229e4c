"""Lower the confidence in harmonics whose periods are no whole parts of a turn, as those of an eccentric gear on the joint are.

A belt over two pulleys, or a gear before the last one, errs with a number of periods a turn that need not be whole. Where a joint turns through a
part of a turn, whole orders near them fit as well. The error ``s sin k q + c cos k q`` changes with k as ``q (s cos k q - c sin k q)``, which gives
each order found a further column, whose coefficient is the distance of the true order from the whole one. If all these columns together explain
something given the model, and such a distance is not small, the orders lie between whole ones. (Small distances are significant where a harmonic is
strong, since no model is exact.) So do three or more high orders in a row that were chosen one by one: together they make a wave between them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.variance_components import columns_by_place
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.scoring.score_test import Projected, gram_given, p_value
from scalar.diagnosis.selection.harmonic_spectrum import is_shrunk
from scalar.effects import Effect
from scalar.effects.series import Series

LEAST_CHANCE = 0.02  # chosen: with a smaller p-value, the orders are not whole
LEAST_DISTANCE = 0.1  # chosen, periods a turn: an order nearer to a whole one is described well enough by it
IN_A_ROW = 3  # chosen: so many neighbouring orders make a wave between them, unless the first are among them, which many gears have together
NOT_WHOLE = "these data fit better with a number of periods in a turn that is not whole, as a belt or a gear before the last one has it"


def limited_by_orders_between(
    found: Sequence[Finding], state: FittedState, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in harmonics of a joint whose orders appear not to be whole.

    Args:
        found: All findings.
        state: The state with their effects.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    return limited_where(
        found, lambda f: _lie_between(f.effect, state), ONE_OF_TWO, least_confidence, NOT_WHOLE
    )


def _lie_between(effect: Effect, state: FittedState) -> bool:
    """Return whether an effect consists of harmonics, chosen one by one, whose orders lie between whole ones."""
    if not isinstance(effect, Series) or is_shrunk(effect) or not effect.change_with_orders(np.zeros(1)).size:
        return False
    rows = np.split(effect.orders, np.flatnonzero(np.diff(effect.orders) != 1) + 1)
    high = any(len(row) >= IN_A_ROW and row[0] > IN_A_ROW for row in rows)
    if high:
        return True
    chance, distance = chance_of_whole_orders(effect, state)
    return chance < LEAST_CHANCE and distance > LEAST_DISTANCE


def chance_of_whole_orders(effect: Series, state: FittedState) -> tuple[float, float]:
    """Return the p-value of what orders near those of an effect, whole or not, explain given a model (an F test), and how far away the farthest is.

    Args:
        effect: An error of one joint with fitted coefficients.
        state: The state with this effect and all others.
    """
    background = state.background()
    by_angle = dict(columns_by_place(state.residuals, state.model)).get(f"q{effect.joint}")
    if by_angle is None:
        return 1.0, 0.0
    by_order = effect.change_with_orders(state.residuals.poses.q[:, effect.joint - 1])
    columns = (by_angle[:, :, None] * by_order[:, None, :]).reshape(-1, by_order.shape[1])
    columns = whitened(state.whitening, columns)
    squares = columns.T @ columns
    every = np.arange(columns.shape[1])[None]
    gain, dof, _ = Projected.of(background, columns, squares, np.full(every.size, np.inf)).score(every)
    distances = (
        np.linalg.pinv(gram_given(background, columns, squares), hermitian=True)
        @ columns.T
        @ background.residual.ravel()
    )
    return float(p_value(background, gain, dof)[0]), float(np.abs(distances).max())
