"""Modified Denavit-Hartenberg parameters of a chain whose joint axes are given as lines in space.

Between two axes that are far from parallel, the x axis of a frame lies along their common normal. Between near-parallel axes the
common normal is badly determined; there the next axis is met in the plane through the frame's origin, and Hayati's beta takes up
the tilt (Hayati and Mirmirani, 1985). Of the two directions that x may have, the one with the smaller theta is taken, which gives
the tables that makers print.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.parallel_axes import NEAR_PARALLEL
from scalar.geometry.robot import GEOMETRY, STANDARD_GRAVITY, Robot, link_transforms
from scalar.geometry.se3 import Array, inverse, transform

ROUNDING = 1e-12
"""[m, rad] What differs less than this from zero, or from a multiple of a right angle, is rounding."""


def robot_from_axes(
    name: str, frames: Array, T_base_flange: Array, limits: Array, prismatic: tuple[int, ...] = ()
) -> Robot:
    """Return the robot with joint axes along the z axes of frames, all at joint angles and travels of zero.

    Args:
        name: Of the arm.
        frames: ``(n, 4, 4)``, in the base frame; the z axis of each is the axis of a joint, its origin any point on it; for a
            prismatic joint any point at all.
        T_base_flange: ``(4, 4)``.
        limits: ``(n, 2)`` [rad, m].
        prismatic: Joints that slide, from 0.

    Returns:
        A robot whose ``flange(q)`` is ``T_base_flange`` at zero and turns about these axes, or slides along them.
    """
    n = len(frames)
    geometry = np.zeros((len(GEOMETRY), n))
    T_base_0 = np.eye(4) if _on_axis(frames[0]) else frames[0].copy()
    before = T_base_0  # the frame of a joint before theta and d, which the next axis decides
    for i in range(n):
        a, alpha, beta = 0.0, 0.0, 0.0
        if i + 1 < n:
            theta, d, a, alpha, beta = _to_next_axis(inverse(before) @ frames[i + 1])
        else:
            theta, d = _to_flange(inverse(before) @ T_base_flange)
        geometry[2, i], geometry[3, i] = d, theta
        after = before @ link_transforms(np.array([0.0, 0.0, d, theta, 0.0])[:, None], np.zeros((1, 1)))[0, 0]
        if i + 1 < n:
            geometry[:, i + 1] = a, alpha, 0.0, 0.0, beta
            before = (
                after @ link_transforms(np.array([a, alpha, 0.0, 0.0, beta])[:, None], np.zeros((1, 1)))[0, 0]
            )
        else:
            T_n_flange = inverse(after) @ T_base_flange
            T_n_flange = np.eye(4) if np.max(np.abs(T_n_flange - np.eye(4))) < ROUNDING else T_n_flange
            return Robot(
                name=name,
                geometry=geometry,
                limits=np.array(limits, dtype=float).reshape(n, 2),
                T_base_0=T_base_0,
                T_n_flange=T_n_flange,
                gravity=np.array(STANDARD_GRAVITY),
                prismatic=prismatic,
            )
    raise ValueError("a chain without joints")


def frame_on_axis(T: Array, axis: Array) -> Array:
    """Return the frame ``(4, 4)`` with the origin of T whose z lies along an axis ``(3,)`` that is given in T, turned as little as may be.

    Where the axis is a coordinate axis of T, the frame's axes are those of T, perhaps in another order.
    """
    axis = np.where(np.abs(axis) < ROUNDING, 0.0, axis)
    axis = axis / np.linalg.norm(axis)
    least = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.5 else least
    x = x - axis * (axis @ x)
    x = x / np.linalg.norm(x)
    return T @ transform(np.column_stack([x, np.cross(axis, x), axis]), np.zeros(3))


def _on_axis(T: Array) -> bool:
    """Return whether the z axis of a frame is that of its reference, in the same direction."""
    return bool(np.max(np.abs(T[:2, 3])) < ROUNDING and T[2, 2] > 0 and np.max(np.abs(T[:2, 2])) < ROUNDING)


def _to_next_axis(T: Array) -> tuple[float, float, float, float, float]:
    """Return theta, d, and a, alpha, beta of the next joint, whose axis is the z axis of a frame ``(4, 4)`` given in that before theta."""
    z, p = T[:3, 2], T[:3, 3]
    across = float(np.hypot(z[0], z[1]))  # sine of the angle between the axes
    near = across < NEAR_PARALLEL
    if near:
        d = 0.0
        x = (p - z * (p[2] / z[2]))[:2]  # where the next axis meets the plane through the origin
        if np.linalg.norm(x) < ROUNDING:
            x = np.array([1.0, 0.0])
    else:
        x = np.array([-z[1], z[0]])  # e_z x z
        along = float(z[:2] @ p[:2]) / across**2
        d = _clean(float(p[2] - z[2] * along))
    x = x / np.linalg.norm(x)
    if x[0] < -ROUNDING or (abs(x[0]) <= ROUNDING and x[1] < 0):
        x = -x
    theta = _clean_angle(float(np.arctan2(x[1], x[0])))
    c, s = np.cos(theta), np.sin(theta)
    turned = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    z, p = turned @ z, turned @ (p - [0.0, 0.0, d])
    beta = _clean_angle(float(np.arcsin(np.clip(z[0], -1.0, 1.0)))) if near else 0.0
    alpha = _clean_angle(float(np.arctan2(-z[1], z[2])))
    met = p - z * (p[2] / z[2]) if near else p
    return theta, d, _clean(float(met[0])), alpha, beta


def _to_flange(T: Array) -> tuple[float, float]:
    """Return theta and d of the last joint: those of a flange ``(4, 4)`` on its axis, else zero."""
    if not _on_axis(T):
        return 0.0, 0.0
    return _clean_angle(float(np.arctan2(T[1, 0], T[0, 0]))), _clean(float(T[2, 3]))


def _clean(value: float) -> float:
    return 0.0 if abs(value) < ROUNDING else value


def _clean_angle(angle: float) -> float:
    steps = np.round(angle / (np.pi / 2))
    return float(steps * np.pi / 2) + 0.0 if abs(angle - steps * np.pi / 2) < ROUNDING else angle
