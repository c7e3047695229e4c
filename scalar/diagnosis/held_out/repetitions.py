"""Poses that were measured several times: what the model lacks at a pose repeats with it, so that they count as one pose.

Poses that differ only in joints that move nothing that is measured (the last joint, if the reflector is on its axis) are repetitions as well.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.settings import DEFAULTS
from scalar.geometry.se3 import Array

_LEAST_READINGS = 3  # of a pose: of two that differ, nothing tells which is wrong


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


def distances_from_other_readings(state: FittedState) -> Array | None:
    """Return how far each measurement is from the median of all measurements of its pose, ``(N,)`` [m]; None if there is none to compare.

    What the model lacks at a pose is in all of its measurements alike, and does not count here. Poses with fewer than three measurements on the same
    plane, which cannot tell which of them is wrong, have the median distance of the others.
    """
    N = state.dataset.n_poses
    residual = state.linearised()[0][: N * state.residuals.measurement.rows_per_pose].reshape(N, -1)
    measured = np.ma.masked_equal(residual, 0.0)  # the row of a target that was not seen is zero
    _, first, of_key = np.unique(
        np.column_stack([first_of_repetitions_of(state), state.dataset.plane_index]),
        axis=0,
        return_index=True,
        return_inverse=True,
    )
    deviation, compared = np.zeros_like(residual), np.zeros(N, dtype=bool)
    for rows in poses_by_repetitions(first[of_key.ravel()]):
        if rows.shape[1] >= _LEAST_READINGS:
            usual = np.ma.median(measured[rows], axis=1, keepdims=True)
            deviation[rows] = (measured[rows] - usual).filled(0.0)
            compared[rows] = True
    sizes = np.linalg.norm(deviation, axis=1)
    if not sizes.any():
        return None
    # Rows are in standard deviations: times the mean length of one.
    length = state.residuals.rms(state.model) / np.sqrt(np.sum(residual**2) / N)
    return length * np.where(compared, sizes, np.median(sizes[compared]))


def poses_by_repetitions(first: Array) -> list[Array]:
    """Return the distinct poses by how often they were measured: for each number of times t, the rows ``(D_t, t)`` of its D_t poses.

    Args:
        first: ``(N,)``, for every pose the index of the first that it repeats.
    """
    _, of_pose, times = np.unique(first, return_inverse=True, return_counts=True)
    together = np.argsort(of_pose, kind="stable")
    begins = np.cumsum(times) - times
    return [together[begins[times == t][:, None] + np.arange(t)] for t in np.unique(times)]
