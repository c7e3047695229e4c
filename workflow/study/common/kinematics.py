"""Forward kinematics for the tracked trials and for tests, as products of elementary 4 x 4 matrices.

Nothing here calls ``scalar``, so that its kinematics are compared with independent ones. ``T_a_b`` takes coordinates in frame b to frame a.
"""

from __future__ import annotations

from typing import Any

import numpy as np

PARAMETER_KINDS = ("a", "alpha", "d", "theta", "beta")
"""The rows of a geometry, an array ``(5, n)`` of the parameters of n joints [m, rad]."""


def rotation(axis: int, angle: Any) -> np.ndarray:
    """Return ``(..., 4, 4)`` rotations about the x, y or z axis (0, 1, 2) by angles ``(...)`` [rad]."""
    angle = np.asarray(angle, dtype=float)
    T = np.zeros((*angle.shape, 4, 4))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[..., axis, axis] = T[..., 3, 3] = 1.0
    T[..., i, i] = T[..., j, j] = np.cos(angle)
    T[..., i, j], T[..., j, i] = -np.sin(angle), np.sin(angle)
    return T


def translation(axis: int, length: Any) -> np.ndarray:
    """Return ``(..., 4, 4)`` translations along the x, y or z axis (0, 1, 2) by lengths ``(...)`` [m]."""
    length = np.asarray(length, dtype=float)
    T = np.zeros((*length.shape, 4, 4))
    T[...] = np.eye(4)
    T[..., axis, 3] = length
    return T


def rotate_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation ``(3, 3)`` by an angle [rad] about any axis ``(3,)``: Rodrigues' formula."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """Return the rotation vectors ``(..., 3)`` [rad] of rotation matrices ``(..., 3, 3)``, accurate for all angles up to pi."""
    m = np.asarray(R, dtype=float)
    # Four multiples of the quaternion; the one with the largest norm is accurate (Shepperd, 1978).
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    xy, xz, yz = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    wx, wy, wz = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    rows = np.stack(
        [
            np.stack([1 + xx + yy + zz, wx, wy, wz], -1),
            np.stack([wx, 1 + xx - yy - zz, xy, xz], -1),
            np.stack([wy, xy, 1 - xx + yy - zz, yz], -1),
            np.stack([wz, xz, yz, 1 - xx - yy + zz], -1),
        ],
        -2,
    )
    best = np.argmax(np.linalg.norm(rows, axis=-1), axis=-1)
    quaternion = np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    quaternion = quaternion * np.where(quaternion[..., :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    return quaternion[..., 1:] * np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)


def transform(mapping: dict[str, Any] | None) -> np.ndarray:
    """Return the transform ``(4, 4)`` that ``{translation [m], rotation_vector [rad]}`` states; None is the identity."""
    T = np.eye(4)
    if mapping:
        T[:3, 3] = mapping.get("translation", [0, 0, 0])
        turn = np.array(mapping.get("rotation_vector", [0, 0, 0]), dtype=float)
        if np.linalg.norm(turn) > 0:
            T[:3, :3] = rotate_about(turn, float(np.linalg.norm(turn)))
    return T


def pose_mapping(T: np.ndarray) -> dict[str, list[float]]:
    """Return ``{translation [m], rotation_vector [rad]}`` of a transform ``(4, 4)``: the inverse of ``transform``."""
    return {"translation": T[:3, 3].tolist(), "rotation_vector": rotation_vector(T[:3, :3]).tolist()}


def random_transform(rng: np.random.Generator, length: float, angle: float) -> np.ndarray:
    """Return a transform ``(4, 4)``: a translation by a length [m] and a rotation by an angle [rad], both in random directions."""
    T = np.eye(4)
    direction = rng.standard_normal(3)
    T[:3, 3] = length * direction / np.linalg.norm(direction)
    T[:3, :3] = rotate_about(rng.standard_normal(3), angle)
    return T


def joint_names(n: int) -> list[str]:
    """Return the columns of the joint angles: q1 to qn."""
    return [f"q{i + 1}" for i in range(n)]


def links(geometry: np.ndarray, q: np.ndarray, T_base_0: np.ndarray | None = None) -> list[np.ndarray]:
    """Return the frames of all joints ``T_base_1`` to ``T_base_n``, each ``(N, 4, 4)``, at angles ``(N, n)`` [rad].

    Each joint multiplies the frame by Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d) from the right (modified DH).

    Args:
        geometry: Parameters ``(5, n)`` in the order of ``PARAMETER_KINDS`` [m, rad], or ``(5, n, N)`` if each pose has its own.
        q: Joint angles.
        T_base_0: ``(4, 4)`` or ``(N, 4, 4)``, the frame before the first joint; None: the base frame.
    """
    T = np.broadcast_to(np.eye(4) if T_base_0 is None else T_base_0, (len(q), 4, 4))
    a, alpha, d, theta, beta = geometry
    frames = []
    for i in range(len(a)):
        before = rotation(0, alpha[i]) @ translation(0, a[i]) @ rotation(1, beta[i])
        T = T @ before @ rotation(2, q[:, i] + theta[i]) @ translation(2, d[i])
        frames.append(T)
    return frames


def chain(geometry: np.ndarray, q: np.ndarray, T_base_0: np.ndarray | None = None) -> np.ndarray:
    """Return the frames of the last joint ``T_base_n`` ``(N, 4, 4)``; the arguments are those of ``links``."""
    return links(geometry, q, T_base_0)[-1]


def standard_chain(rows: list[tuple[float, float, float, float]], q: np.ndarray) -> np.ndarray:
    """Return the frames after the last joint ``(N, 4, 4)`` by the standard DH convention, at angles ``(N, n)`` [rad].

    Each joint multiplies the frame by Rz(q + theta) Tz(d) Tx(a) Rx(alpha) from the right.

    Args:
        rows: (theta, d, a, alpha) of each joint [m, rad].
        q: Joint angles.
    """
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for i, (theta, d, a, alpha) in enumerate(rows):
        T = T @ rotation(2, q[:, i] + theta) @ translation(2, d) @ translation(0, a) @ rotation(0, alpha)
    return T


def best_motion(points: np.ndarray, onto: np.ndarray) -> np.ndarray:
    """Return the rigid motion ``(4, 4)`` that brings points ``(N, 3)`` nearest to others ``(N, 3)`` (Kabsch, 1976)."""
    U, _, Vt = np.linalg.svd((onto - onto.mean(0)).T @ (points - points.mean(0)))
    T = np.eye(4)
    T[:3, :3] = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    T[:3, 3] = onto.mean(0) - T[:3, :3] @ points.mean(0)
    return T
