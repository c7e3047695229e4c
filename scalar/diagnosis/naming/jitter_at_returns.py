"""Lower the confidence in a jitter of the joints that returns to the same poses do not bear out.

A joint that does not repeat, and an unknown error that depends on the joint angles in a complicated way (the pull of a hose, a loose mount), scatter
the poses alike: to a test over different poses, an error with many short waves is random. Only a return to the same joint angles distinguishes them:
the error of a jitter is then independent of the one before, and an error that depends on the angles is the same.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import JITTER, VarianceComponent
from scalar.diagnosis.held_out.repetitions import first_of_repetitions
from scalar.diagnosis.naming.most_confidence import NOT_SURE
from scalar.diagnosis.noise.repeated_poses import SAME_ANGLES
from scalar.estimation.design_effect import standstills
from scalar.geometry.se3 import Array

NO_RETURNS = "no returns to the same poses bear it out, and the pull of a hose or a loose mount scatters poses that all differ alike"
# Chosen: share of the variance that measurements of one pose may have in common. With more, the larger part is an error that depends on the angles.
MOST_COMMON_SHARE = 0.5
STANDARD_ERRORS = 2.0  # by which the share has to be below that


def most_confidence_at_returns(state: FittedState, component: VarianceComponent) -> float:
    """Return the largest confidence in the name of a variance component: 1 unless it is a jitter that returns to the same poses do not bear out.

    Args:
        state: The state with all effects that were found.
        component: The component.
    """
    if component.name != JITTER:
        return 1.0
    share, error = share_in_common(state, component)
    return 1.0 if share + STANDARD_ERRORS * error < MOST_COMMON_SHARE else NOT_SURE


def share_in_common(state: FittedState, component: VarianceComponent) -> tuple[float, float]:
    """Return the share of a component's variance that measurements of the same pose have in common, and its standard error, infinite without returns.

    The share is the mean product of the whitened residuals of two measurements of one pose over the mean variance that the component adds to them. It
    is about 0 for a random error, and about 1 for an error that belongs to the pose.

    Args:
        state: The state with all effects that were found.
        component: The component.
    """
    dataset = state.dataset
    N, m = dataset.n_poses, state.residuals.measurement.rows_per_pose
    pairs = _returns(dataset.q, dataset.known_poses.order, state.residuals.measurement.target_index)
    if not len(pairs):
        return 0.0, np.inf
    z = state.background_within_scans().residual[: N * m].reshape(N, m)
    added = component.std**2 * np.einsum("nii->n", component.kernel)
    products = np.sum(z[pairs[:, 0]] * z[pairs[:, 1]], axis=1)
    variance = float(np.sum(np.sqrt(added[pairs[:, 0]] * added[pairs[:, 1]])))
    if variance == 0:
        return 0.0, np.inf
    return float(np.sum(products)) / variance, float(np.sqrt(np.sum(products**2))) / variance


def _returns(q: Array, order: Array, target: Array) -> Array:
    """Return the rows ``(P, 2)`` of two standstills at the same joint angles and with the same target, each row in one pair at most.

    Args:
        q: Joint coordinates ``(N, n)`` [rad, or m of a joint that slides].
        order: ``(N,)``, the order of acquisition.
        target: ``(N,)``, the index of the target that each row measures.
    """
    place, standstill = first_of_repetitions(q, SAME_ANGLES), standstills(q, order)
    read: dict[tuple[int, int], list[int]] = {}
    for i in np.argsort(order, kind="stable").tolist():
        rows = read.setdefault((int(place[i]), int(target[i])), [])
        if not rows or standstill[rows[-1]] != standstill[i]:
            rows.append(i)
    pairs = [pair for rows in read.values() for pair in zip(rows[::2], rows[1::2], strict=False)]
    return np.array(pairs, dtype=int).reshape(-1, 2)
