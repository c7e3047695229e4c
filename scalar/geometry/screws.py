"""Screws: how rigid motions move points, batched over poses.

A screw is ``(w, v)``: the angular velocity [rad] and the velocity of the point that coincides with the origin [m], so that a
point moves by ``dp = w x p + v``. The derivative of a frame by a parameter is a screw; k of them are an array ``(N, 6, k)``.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array, exp_so3, left_jacobian_so3, skew, transform


def exp_screw(screw: Array) -> Array:
    """Return the transform ``(..., 4, 4)`` by which a small screw ``(..., 6)``, (w [rad], v [m]), moves points.

    The rotation is ``exp(w)``, and ``v`` is applied as a translation. This is a rigid motion for every argument, and at zero it has the same
    derivative as the exponential of se(3); for corrections of some milliradians the two hardly differ.
    """
    return transform(exp_so3(screw[..., :3]), screw[..., 3:])


def exp_screw_derivative(screw: Array, by_parameter: Array) -> Array:
    """Return the screws ``(N, 6, k)`` of ``exp_screw(screw)`` by the k parameters on which the screw ``(N, 6)`` depends.

    ``exp_screw`` takes a point ``p_0`` to ``p = exp(w) p_0 + v``, so ``dp = (J_l dw) x (p - v) + dv``.

    Args:
        screw: ``(N, 6)``, (w [rad], v [m]).
        by_parameter: ``(N, 6, k)``, the derivatives of the screw by the parameters.
    """
    if not screw.any():
        return by_parameter
    w = left_jacobian_so3(screw[:, :3]) @ by_parameter[:, :3]
    return np.concatenate([w, by_parameter[:, 3:] + skew(screw[:, 3:]) @ w], axis=1)


def change_frame(T: Array, screws: Array) -> Array:
    """Return in frame a the screws ``(N, 6, k)`` that are given in frame b.

    This is the adjoint action of ``T_a_b`` (Lynch and Park, Modern Robotics, 3.83): ``w_a = R w_b``, ``v_a = R v_b + t x w_a``.

    Args:
        T: ``T_a_b``, ``(N, 4, 4)``.
        screws: ``(N, 6, k)``, in frame b.
    """
    R, t = T[:, :3, :3], T[:, :3, 3]
    w = R @ screws[:, :3]
    v = R @ screws[:, 3:]
    return np.concatenate([w, v + skew(t) @ w], axis=1)


def rotations_about(axes: Array, points: Array) -> Array:
    """Return the screws ``(N, 6, k)`` of rotations about ``axes`` ``(N, 3, k)`` through ``points`` ``(N, 3)`` [m]."""
    return np.concatenate([axes, skew(points) @ axes], axis=1)
