"""Lower the confidence in a scatter from reading to reading of which a part is the same in readings that follow each other.

A variance component describes an error that is another at each reading. A laser whose zero wanders, or a mount that is loose and rests on one side
for a while, has nearly the same error in successive readings, whatever the joint angles are (``smooth_shares``, with the distance in the order of
acquisition). So does an error with a name, if the poses were measured one near the other.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.noise.smooth_share import MOST_POSES, MOST_SHARE, smooth_shares
from scalar.estimation.design_effect import standstills
from scalar.geometry.se3 import Array

RUN = 30  # chosen: of many readings, runs of so many that follow each other are looked at
# Chosen: over so many readings the correlation falls to 0.6; a short memory and a long one.
READINGS_ALIKE = (3.0, 10.0)
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
    return ONE_OF_TWO if max(shown) > MOST_SHARE else NOT_SURE


def shares_in_time(state: FittedState, component: VarianceComponent) -> list[tuple[float, float]]:
    """Return the share of a component's variance that varies smoothly in the order of acquisition, and its standard error (``smooth_shares``).

    There is one for each of ``READINGS_ALIKE``.

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
    # What several targets show of one stop is one error, of whatever kind.
    apart = stops[:, None] != stops[None, :]
    nearness = [apart * _nearness(order[by_time], alike) for alike in READINGS_ALIKE]
    return smooth_shares(state, component, by_time, nearness)


def _nearness(order: Array, alike: float) -> Array:
    """Return how nearly alike an error that varies smoothly in time is at two readings ``(N, N)``.

    Args:
        order: ``(N,)``, the order of acquisition.
        alike: Number of readings over which the correlation falls to 0.6.
    """
    return np.exp(-0.5 * ((order[:, None] - order[None, :]) / alike) ** 2)
