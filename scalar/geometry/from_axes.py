"""Modified Denavit-Hartenberg parameters of a chain whose joint axes are given as lines in space.

Between two axes that are far from parallel, the x axis of a frame lies along their common normal. Between near-parallel axes the
common normal is badly determined. There d is zero, x points from the frame's origin to where the next axis crosses the frame's xy
plane, and Hayati's beta describes the tilt (Hayati and Mirmirani, 1985). Of the two directions that x may have, the one with the smaller
absolute theta is taken, as in the tables that makers print.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.parallel_axes import NEAR_PARALLEL
from scalar.geometry.robot import GEOMETRY, STANDARD_GRAVITY, Robot, link_transforms
from scalar.geometry.se3 import Array, inverse, transform

ROUNDING = 1e-12
"""[m, rad, or a component of a unit vector] A number that is closer than this to zero, or an angle that is closer to a multiple of a right
angle, differs from it by rounding alone."""


def robot_from_axes(
    name: str, frames: Array, T_base_flange: Array, limits: Array, prismatic: tuple[int, ...] = ()
) -> Robot:
    """Return the robot whose joint axes are the z axes of given frames when all its joint angles and travels are zero.

    Args:
        name: Name of the arm.
        frames: ``(n, 4, 4)``, in the base frame. The z axis of each is the axis of a joint; the origin is any point on that axis, and for a
            prismatic joint any point at all.
        T_base_flange: ``(4, 4)``, where the flange is at joint angles and travels of zero.
        limits: ``(n, 2)`` [rad; m for a prismatic joint], lowest and highest joint angle or travel.
        prismatic: Indices, from 0, of the joints that slide.

    Returns:
        A robot whose ``flange(q)`` is ``T_base_flange`` at ``q = 0`` and turns about these axes, or slides along them.

    Raises:
        IndexError: There are no frames.
    """
    n = len(frames)
    geometry = np.zeros((len(GEOMETRY), n))
    T_base_0 = np.eye(4) if _on_axis(frames[0]) else frames[0].copy()
    before = T_base_0  # the frame of joint i before its theta and d, which the next axis determines
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
    """Return the frame ``(4, 4)`` with the origin of T ``(4, 4)`` and with z along an axis ``(3,)``, given in T, of any length.

    Its x axis is that of T made perpendicular to z. If z is within 60 degrees of T's x axis or its opposite, the coordinate axis of T that
    is the most nearly perpendicular to z is taken instead. For an axis along a coordinate axis of T, all axes of the frame are coordinate
    axes of T or their opposites.
    """
    axis = np.where(np.abs(axis) < ROUNDING, 0.0, axis)
    axis = axis / np.linalg.norm(axis)
    least = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.5 else least
    x = x - axis * (axis @ x)
    x = x / np.linalg.norm(x)
    return T @ transform(np.column_stack([x, np.cross(axis, x), axis]), np.zeros(3))


def _on_axis(T: Array) -> bool:
    """Return whether a frame ``(4, 4)``, given in a reference frame, has its z axis on that of the reference, in the same direction."""
    return bool(np.max(np.abs(T[:2, 3])) < ROUNDING and T[2, 2] > 0 and np.max(np.abs(T[:2, 2])) < ROUNDING)


def _to_next_axis(T: Array) -> tuple[float, float, float, float, float]:
    """Return theta and d of a joint, and a, alpha and beta of the next one, whose axis is the z axis of T.

    T ``(4, 4)`` is given in the frame that the joint has before its theta and d.
    """
    z, p = T[:3, 2], T[:3, 3]
    across = float(np.hypot(z[0], z[1]))  # sine of the angle between the axes
    near = across < NEAR_PARALLEL
    if near:
        d = 0.0
        x = (p - z * (p[2] / z[2]))[:2]  # where the next axis crosses the xy plane
        if np.linalg.norm(x) < ROUNDING:
            x = np.array([1.0, 0.0])
    else:
        x = np.array([-z[1], z[0]])  # e_z x z
        along = float(z[:2] @ p[:2]) / across**2
        d = _zero_if_rounding(float(p[2] - z[2] * along))
    x = x / np.linalg.norm(x)
    if x[0] < -ROUNDING or (abs(x[0]) <= ROUNDING and x[1] < 0):
        x = -x
    theta = _right_angle_if_rounding(float(np.arctan2(x[1], x[0])))
    c, s = np.cos(theta), np.sin(theta)
    R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    z, p = R @ z, R @ (p - [0.0, 0.0, d])  # in the joint's frame after theta and d
    beta = _right_angle_if_rounding(float(np.arcsin(np.clip(z[0], -1.0, 1.0)))) if near else 0.0
    alpha = _right_angle_if_rounding(float(np.arctan2(-z[1], z[2])))
    # Far from parallel, x is the same at every point of the next axis.
    crossing = p - z * (p[2] / z[2]) if near else p
    return theta, d, _zero_if_rounding(float(crossing[0])), alpha, beta


def _to_flange(T: Array) -> tuple[float, float]:
    """Return theta and d of the last joint, so that its frame is the flange's, if the flange's z axis lies on the joint's; else zeros.

    T ``(4, 4)`` is the flange in the frame that the joint has before its theta and d.
    """
    if not _on_axis(T):
        return 0.0, 0.0
    return _right_angle_if_rounding(float(np.arctan2(T[1, 0], T[0, 0]))), _zero_if_rounding(float(T[2, 3]))


def _zero_if_rounding(value: float) -> float:
    return 0.0 if abs(value) < ROUNDING else value


def _right_angle_if_rounding(angle: float) -> float:
    steps = np.round(angle / (np.pi / 2))
    return float(steps * np.pi / 2) + 0.0 if abs(angle - steps * np.pi / 2) < ROUNDING else angle
