"""Poses that were measured several times: what the model lacks at a pose repeats with it, so that they count as one pose.

Poses that differ only in joints that move nothing that is measured (the last joint, if the reflector is on its axis) are repetitions as well.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.settings import DEFAULTS
from scalar.geometry.se3 import Array


def moving_joints(state: FittedState) -> Array:
    """Return which joints move what is measured, ``(n,)`` bool: their derivatives are at least ``settings.hold_out.least_derivative``."""
    sizes = state.rows.derivatives_by_joint(state.residuals, state.model)
    return sizes >= state.settings.hold_out.least_derivative


def first_of_repetitions(q: Array, same_pose: float = DEFAULTS.hold_out.same_pose) -> Array:
    """Return for every pose the index ``(N,)`` of the first pose of which it is a repetition, its own if it repeats none.

    Args:
        q: Joint coordinates ``(N, n)`` [rad, or m of a joint that slides].
        same_pose: A pose whose coordinates all differ by less is a repetition, in the same unit.
    """
    first = np.arange(len(q))
    pairs = KDTree(q).query_pairs(same_pose, p=np.inf, output_type="ndarray")
    for i, j in pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]:
        first[j] = min(first[j], first[i])
    return first


def first_of_repetitions_of(state: FittedState) -> Array:
    """Return for every pose of a state the index ``(N,)`` of the first that it repeats; only joints that move what is measured distinguish poses."""
    moving, same_pose = moving_joints(state), state.settings.hold_out.same_pose
    return state.rows.once(
        ("first", same_pose, *moving.tolist()),
        lambda: first_of_repetitions(state.dataset.q[:, moving], same_pose),
    )


def distinct_poses(state: FittedState) -> Array:
    """Return which poses ``(N,)`` bool repeat no earlier one: the equations of a repetition show the noise, and no more of the arm."""
    first = first_of_repetitions_of(state)
    return first == np.arange(len(first))


def distinct_equations(state: FittedState) -> int:
    """Return the number of equations that were measured at distinct poses."""
    return int(state.residuals.measurement.equations[distinct_poses(state)].sum())


def poses_by_repetitions(first: Array) -> list[Array]:
    """Return the distinct poses by how often they were measured: for each number of times t, the rows ``(D_t, t)`` of its D_t poses.

    Args:
        first: ``(N,)``, for every pose the index of the first that it repeats.
    """
    _, of_pose, times = np.unique(first, return_inverse=True, return_counts=True)
    together = np.argsort(of_pose, kind="stable")
    begins = np.cumsum(times) - times
    return [together[begins[times == t][:, None] + np.arange(t)] for t in np.unique(times)]
