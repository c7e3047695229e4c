"""Quaternions ``qw + qx i + qy j + qz k`` of norm 1; q and -q are the same rotation."""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

_NORM_TOLERANCE = 1e-2  # most by which a quaternion's norm may differ from 1: rounding differs by less, other quantities by more


def rotation_vectors_from_quaternions(q: Array) -> tuple[Array, Array]:
    """Return rotation vectors ``(N, 3)`` [rad], and the norms ``(N,)`` of the quaternions that cannot be rotations.

    Args:
        q: ``(N, 4)``, in the order ``qw, qx, qy, qz``.

    Returns:
        The norm is NaN where it is 1 within rounding, or where the quaternion holds a NaN. Vectors of all quaternions without a norm near 1 are zero.
    """
    from scipy.spatial.transform import Rotation  # slow to import

    norm = np.linalg.norm(q, axis=1)
    near_one = np.abs(norm - 1.0) <= _NORM_TOLERANCE
    known = np.where(near_one[:, None], q, [1.0, 0.0, 0.0, 0.0])
    return Rotation.from_quat(known, scalar_first=True).as_rotvec(), np.where(near_one, np.nan, norm)


def quaternions_from_rotations(R: Array) -> Array:
    """Return the quaternions ``(N, 4)``, in the order ``qw, qx, qy, qz`` and with ``qw >= 0``, of rotations ``(N, 3, 3)``."""
    from scipy.spatial.transform import Rotation  # slow to import

    return Rotation.from_matrix(R).as_quat(canonical=True, scalar_first=True)
