"""Lower the confidence in the name of a variance component if successive readings have partly the same error.

A variance component describes an error that is independent from reading to reading. A laser whose zero wanders, or a mount that is loose and rests on
one side for a while, has nearly the same error in successive readings, whatever the joint angles are (``smooth_shares``, with the distance in the
order of acquisition). So does an error with a name, if the poses were measured one near the other.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.noise.smooth_share import MOST_POSES, MOST_SMOOTH_SHARE, smooth_shares
from scalar.estimation.design_effect import standstills
from scalar.geometry.se3 import Array

RUN = 30  # chosen: of more than MOST_POSES readings, runs of so many successive ones are compared
# Numbers of readings over which the correlation falls to 0.6, chosen: an error that changes soon, and one that lasts.
CORRELATION_LENGTHS = (3.0, 10.0)
STANDARD_ERRORS = 2.0  # by which the share has to exceed zero
SMALL_SHARE = 0.1  # chosen: a smaller share is no objection, however significant it is
FOLLOWS_TIME = "successive readings have nearly the same error, which a random error does not"


def most_confidence_in_time(state: FittedState, component: VarianceComponent) -> float:
    """Return the largest confidence in the name of a variance component: 1 unless successive readings have nearly the same error.

    Args:
        state: The state with all effects that were found.
        component: The component.
    """
    shares = state.once(("shares in time", component), lambda: shares_in_time(state, component))
    shown = [share for share, error in shares if share > max(SMALL_SHARE, STANDARD_ERRORS * error)]
    if not shown:
        return 1.0
    return ONE_OF_TWO if max(shown) > MOST_SMOOTH_SHARE else NOT_SURE


def shares_in_time(state: FittedState, component: VarianceComponent) -> list[tuple[float, float]]:
    """Return the share of a component's variance that varies smoothly in the order of acquisition, and its standard error (``smooth_shares``).

    There is one for each of ``CORRELATION_LENGTHS``.

    Args:
        state: The state with all effects that were found.
        component: The component.
    """
    order = np.asarray(state.dataset.known_poses.order, dtype=float)
    by_time = np.argsort(order, kind="stable")
    if len(order) > MOST_POSES:
        starts = np.linspace(0, len(order) - RUN, MOST_POSES // RUN).astype(int)
        by_time = by_time[np.unique(starts[:, None] + np.arange(RUN))]
    stops = standstills(state.dataset.q, order)[by_time]
    # Readings of several targets at one stop have one error, of whatever kind: they are not compared.
    apart = stops[:, None] != stops[None, :]
    correlations = [apart * _correlation_in_time(order[by_time], length) for length in CORRELATION_LENGTHS]
    return smooth_shares(state, component, by_time, correlations)


def _correlation_in_time(order: Array, length: float) -> Array:
    """Return the correlation ``(N, N)`` of an error that varies smoothly in time at two readings.

    Args:
        order: ``(N,)``, the order of acquisition.
        length: Number of readings over which the correlation falls to 0.6.
    """
    return np.exp(-0.5 * ((order[:, None] - order[None, :]) / length) ** 2)
