"""The joint angles near given ones that come nearest to a wanted frame that they cannot take exactly: a home pose with a straight wrist, say.

At a singularity an exact solution may be far away: a straight wrist turns by up to a quarter turn for a milliradian. By small changes the
position comes first, and the orientation takes what is left: ``dq = P e_p + (J_o N)^+ (e_o - J_o P e_p)``, with J_p and J_o the rows of the Jacobian
for position and orientation, P the pseudo-inverse of J_p and N the projector on its null space (Nakamura, Hanafusa and Yoshikawa 1987).
Singular values below ``near_singular`` count as zero, so that no joint makes a large move.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.correction.inverse import arm_length, jacobian, twist_to
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.displacement import kinematics_at
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array

_STEPS, _HALVINGS = 15, 8
_NULL = 1e-9  # singular values below it are zero: their singular vectors are arbitrary
_TURN = 0.1  # weight of a radian, relative to a shift by the arm's length, in the sum of squares that each step has to lower


def nearest_by_small_changes(
    model: Model, poses: Poses, T_wanted: Array, settings: CorrectionSettings
) -> tuple[Array, Array]:
    """Return joint angles ``(N, n)`` [rad] near those of poses that come nearest to wanted frames, and the twists that remain ``(N, 6)`` [rad, m].

    The position comes first. A joint changes by at most ``settings.small_change``, and a pose that no step improves stays as it is.

    Args:
        model: The calibrated one.
        poses: Joint angles to start from, with the columns that the effects need.
        T_wanted: ``(N, 4, 4)``, frames of the sensor in the base frame.
        settings: Thresholds.
    """
    scales = _scales(model)
    weights = np.array([_TURN] * 3 + [1.0] * 3) / scales

    def at(q: Array) -> tuple[Array, Array, Array]:
        kinematics = kinematics_at(model, replace(poses, q=q))
        twist = twist_to(kinematics.T_base_sensor, T_wanted)
        return jacobian(kinematics) / scales[:, None], twist, np.sum((weights * twist) ** 2, axis=1)

    q = poses.q.copy()
    J, twist, cost = at(q)
    for _ in range(_STEPS):
        step = _step(J, twist / scales, settings.near_singular)
        improved = np.zeros(len(q), dtype=bool)
        for _ in range(_HALVINGS):
            tried = q + step
            new_J, new_twist, new_cost = at(tried)
            better = (new_cost < cost) & ~improved
            better &= np.abs(tried - poses.q).max(axis=1) <= settings.small_change
            q[better], J[better], twist[better] = tried[better], new_J[better], new_twist[better]
            cost[better] = new_cost[better]
            improved |= better
            if improved.all():
                break
            step = np.where(improved[:, None], 0.0, step / 2)
        if not improved.any():
            break
    return q, twist


def _step(J: Array, e: Array, least: float) -> Array:
    """Return the steps ``(N, n)`` of position before orientation.

    Args:
        J: ``(N, 6, n)``, rotation before shift, lengths in units of the arm's.
        e: ``(N, 6)``, the twists to the wanted frames in the same units.
        least: Smaller singular values count as zero.
    """
    Jo, Jp = J[:, :3], J[:, 3:]
    U, s, Vt = np.linalg.svd(Jp, full_matrices=False)
    rows = Vt * (s > _NULL)[:, :, None]
    N = np.eye(J.shape[2]) - np.swapaxes(rows, 1, 2) @ rows
    step = _times(_truncated_inverse(U, s, Vt, least), e[:, 3:])
    left = e[:, :3] - _times(Jo, step)
    return step + _times(_truncated_inverse(*np.linalg.svd(Jo @ N, full_matrices=False), least), left)


def _truncated_inverse(U: Array, s: Array, Vt: Array, least: float) -> Array:
    inverse = np.where(s > least, 1.0 / np.maximum(s, least), 0.0)
    return (np.swapaxes(Vt, 1, 2) * inverse[:, None, :]) @ np.swapaxes(U, 1, 2)


def _times(A: Array, x: Array) -> Array:
    return (A @ x[:, :, None])[:, :, 0]


def _scales(model: Model) -> Array:
    """Return the units ``(6,)`` in which the rows of a Jacobian are compared: radians, and the arm's length [m]."""
    return np.array([1.0] * 3 + [arm_length(model.nominal)] * 3)
