"""Distinguish a jitter of the joints from an error that varies smoothly with the joint angles, by poses that are near each other.

Where nothing in the model explains the pull of a hose or a floor that gives way, these scatter poses that all differ as a random error of the joints
does. At two poses whose joint angles are near each other, however, such an error is nearly the same, and that of a jitter is independent
(``smooth_shares``). Whether the poses are near enough to show this depends on their number and on the ranges of the joints.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.noise.smooth_share import MOST_POSES, MOST_SMOOTH_SHARE, smooth_shares
from scalar.geometry.se3 import Array

# Chosen [rad, or m of a joint that slides], of each joint: over so much, an error with one period in a turn falls from its largest value to zero.
CORRELATION_LENGTH = 1.5
ONE_SIDED = 1.645  # standard errors: 95 % of a normal variable lies below


def excludes_smooth_error(state: FittedState, component: VarianceComponent) -> bool:
    """Return whether neighbouring poses show that less than ``MOST_SMOOTH_SHARE`` of a jitter's variance varies smoothly with the joint angles.

    Args:
        state: The state with all effects that were found.
        component: The jitter.
    """
    share, error = state.once(("smooth share", component), lambda: share_by_angles(state, component))
    return share + ONE_SIDED * error < MOST_SMOOTH_SHARE


def share_by_angles(state: FittedState, component: VarianceComponent) -> tuple[float, float]:
    """Return the share of a jitter's variance that varies smoothly with the joint angles, and its standard error (``smooth_shares``).

    Args:
        state: The state with all effects that were found.
        component: The jitter.
    """
    N = len(state.dataset.q)
    poses = np.unique(np.linspace(0, N - 1, min(N, MOST_POSES)).astype(int))
    return smooth_shares(state, component, poses, [_correlation_by_angles(state.dataset.q[poses])])[0]


def _correlation_by_angles(q: Array) -> Array:
    """Return the correlation ``(N, N)`` of a smooth error at two poses: 1 at the same joint angles.

    Args:
        q: Joint coordinates ``(N, n)`` [rad, or m of a joint that slides].
    """
    apart = np.sum((q[:, None, :] - q[None, :, :]) ** 2, axis=2)
    return np.exp(-0.5 * apart / CORRELATION_LENGTH**2)
