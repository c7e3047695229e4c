"""By how much a wrong set-up changes predictions after the best move of the base and of the sensor's frame."""

from __future__ import annotations

import itertools

import numpy as np

from study.common.kinematics import best_motion, rotation

ROUNDS = 40
QUARTERS = np.arange(4) * np.pi / 2


def least_change(right: np.ndarray, wrong: np.ndarray, points: np.ndarray) -> float:
    """Return the RMS distance [m] of points on the flange between two descriptions of an arm, after the best moves of base and sensor.

    It is the least over rigid motions X and Y of the RMS of ``|wrong Y p - X right p|``. X and Y are fitted in turn, each in closed form, from
    Y at every quarter turn about the axes.

    Args:
        right: Frames of the flange ``(N, 4, 4)`` by the true arm at the measured poses.
        wrong: The same by the wrong description.
        points: ``(K, 3)`` [m], points in the flange's frame. With a single one, the sensor's orientation does not matter.
    """
    to = _placed(right, points)  # (N, K, 3)
    R, t = wrong[:, :3, :3], wrong[:, :3, 3]
    least = np.inf
    for turn_z, turn_x in itertools.product(QUARTERS, QUARTERS[[0, 2]]):
        Y = rotation(2, turn_z) @ rotation(0, turn_x)
        now = np.inf
        for _ in range(ROUNDS):
            body = points @ Y[:3, :3].T + Y[:3, 3]
            came = _placed(wrong, body)
            X = best_motion(to.reshape(-1, 3), came.reshape(-1, 3))
            moved = to @ X[:3, :3].T + X[:3, 3]
            change = float(np.sqrt(np.mean(np.sum((came - moved) ** 2, axis=-1))))
            if change > 0.999 * now:
                break
            now = change
            in_flange = np.einsum("nji,nkj->nki", R, moved - t[:, None, :]).mean(axis=0)
            Y = best_motion(points, in_flange)
        least = min(least, now)
    return least


def _placed(frames: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points ``(K, 3)`` of the flange's frame in the base ``(N, K, 3)``."""
    return np.einsum("nij,kj->nki", frames[:, :3, :3], points) + frames[:, None, :3, 3]
