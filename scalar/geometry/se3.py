"""Rigid transforms and rotations as plain arrays, batched over leading dimensions.

``T_a_b`` takes coordinates in frame b to frame a. Screws, the derivatives of transforms, are in ``scalar.geometry.screws``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]
"""An array; of float64, or of integers or booleans where a docstring says index, count or mask."""

_SMALL_ANGLE = 1e-4  # rad; below it the first terms of the left Jacobian's series are exact to 1e-13


def transform(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Return the ``(..., 4, 4)`` transform of a rotation ``(..., 3, 3)`` and a translation ``(..., 3)`` [m]."""
    rotation = np.asarray(rotation, dtype=float)
    translation = np.asarray(translation, dtype=float)
    shape = rotation.shape[:-2], translation.shape[:-1]
    T = np.zeros((*(np.broadcast_shapes(*shape) if any(shape) else ()), 4, 4))
    T[..., :3, :3] = rotation
    T[..., :3, 3] = translation
    T[..., 3, 3] = 1.0
    return T


def transform_from_rotation_vector(translation: ArrayLike, rotation_vector: ArrayLike) -> Array:
    """Return the ``(..., 4, 4)`` transform of a translation ``(..., 3)`` [m] and a rotation vector ``(..., 3)`` [rad]."""
    return transform(exp_so3(rotation_vector), translation)


def inverse(T: Array) -> Array:
    """Return ``T^-1`` of rigid transforms ``(..., 4, 4)``."""
    R_t = np.swapaxes(T[..., :3, :3], -1, -2)
    return transform(R_t, -(R_t @ T[..., :3, 3:])[..., 0])


def exp_so3(rotation_vector: ArrayLike) -> Array:
    """Return the rotation ``(..., 3, 3)`` of a rotation vector ``(..., 3)`` [rad]."""
    if np.ndim(rotation_vector) == 1:
        return _rotation(*np.asarray(rotation_vector, dtype=float).tolist())
    from scipy.spatial.transform import Rotation  # slow to import, and not needed to read a dataset

    rotation_vector = np.array(rotation_vector, dtype=float)  # a copy: SciPy refuses pandas' read-only views
    R = Rotation.from_rotvec(rotation_vector.reshape(-1, 3)).as_matrix()
    return R.reshape(*rotation_vector.shape[:-1], 3, 3)


def _rotation(x: float, y: float, z: float) -> Array:
    """Return the rotation ``(3, 3)`` of one rotation vector r [rad], ``I + sin(t)/t [r]x + (1 - cos t)/t^2 [r]x^2``, t = |r|: faster than SciPy."""
    t = math.sqrt(x * x + y * y + z * z)
    if t == 0.0:
        return np.eye(3)
    half = math.sin(t / 2) / (t / 2)
    a, b = math.sin(t) / t, half * half / 2
    return np.array(
        [
            [1 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1 - b * (x * x + y * y)],
        ]
    )


def log_so3(R: Array) -> Array:
    """Return the rotation vector ``(..., 3)`` [rad], of length at most pi, of rotations ``(..., 3, 3)``."""
    if R.ndim == 2:
        return _rotation_vector(R)
    from scipy.spatial.transform import Rotation

    rotation_vector = Rotation.from_matrix(np.array(R, dtype=float).reshape(-1, 3, 3)).as_rotvec()
    return rotation_vector.reshape(*R.shape[:-2], 3)


def _rotation_vector(R: Array) -> Array:
    """Return the rotation vector ``(3,)`` [rad] of one rotation, by its quaternion (Shepperd 1978): faster than SciPy."""
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    trace = a + e + i
    # Multiples of the quaternion (x, y, z, w), by four times one of its components each; the largest loses no digits.
    multiples = (
        (1 + 2 * a - trace, b + d, c + g, h - f),
        (b + d, 1 + 2 * e - trace, f + h, c - g),
        (c + g, f + h, 1 + 2 * i - trace, d - b),
        (h - f, c - g, d - b, 1 + trace),
    )
    components = (a, e, i, trace)
    x, y, z, w = multiples[components.index(max(components))]
    size = math.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return np.zeros(3)
    factor = 2 * math.atan2(size, abs(w)) / math.copysign(size, w)
    return np.array([x * factor, y * factor, z * factor])


def cross(u: Array, v: Array) -> Array:
    """Return ``u x v`` ``(..., 3)`` of vectors ``(..., 3)``; the same as ``numpy.cross``, several times faster on many short rows."""
    u0, u1, u2 = u[..., 0], u[..., 1], u[..., 2]
    v0, v1, v2 = v[..., 0], v[..., 1], v[..., 2]
    first = u1 * v2 - u2 * v1
    found = np.empty((*first.shape, 3), dtype=first.dtype)
    found[..., 0], found[..., 1], found[..., 2] = first, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    return found


def skew(w: ArrayLike) -> Array:
    """Return ``[w]x``, ``(..., 3, 3)``, with ``[w]x p = w x p``."""
    w = np.asarray(w, dtype=float)
    W = np.zeros((*w.shape[:-1], 3, 3))
    W[..., 0, 1], W[..., 0, 2], W[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    W[..., 1, 0], W[..., 2, 0], W[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return W


def left_jacobian_so3(rotation_vector: ArrayLike) -> Array:
    """Return ``J_l``, ``(..., 3, 3)``, with ``exp(r + dr) = exp(J_l dr) exp(r)`` to first order, for ``r`` ``(..., 3)`` [rad].

    ``J_l = I + (1 - cos t)/t^2 [r]x + (t - sin t)/t^3 [r]x^2``, t = |r| (Barfoot, State Estimation for Robotics, 7.85).
    """
    r = np.asarray(rotation_vector, dtype=float)
    angle = np.linalg.norm(r, axis=-1)[..., None, None]
    small = angle < _SMALL_ANGLE
    t = np.where(small, 1.0, angle)
    first = np.where(small, 0.5, (1 - np.cos(t)) / t**2)
    second = np.where(small, 1.0 / 6.0, (t - np.sin(t)) / t**3)
    W = skew(r)
    return np.eye(3) + first * W + second * (W @ W)


def rotation_angle(R: Array) -> Array:
    """Return the angle ``(...)`` [rad], 0 to pi, of rotations ``(..., 3, 3)``, accurate near zero.

    ``R - R^T`` is ``2 sin(angle) [axis]x``, and the trace of R is ``1 + 2 cos(angle)``.
    """
    sine = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]])
    trace = R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2]
    return np.arctan2(np.linalg.norm(sine, axis=0), trace - 1.0)


def nearest_rotation(matrix: Array) -> Array:
    """Return the rotation ``(3, 3)`` nearest to a matrix (Kabsch 1976): for a mean of rotation matrices, the mean rotation."""
    U, _, Vt = np.linalg.svd(matrix)
    return U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
