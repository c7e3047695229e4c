"""Return rotations and rigid transforms as matrices, for the simulator alone.

The estimator has its own (`scalar.geometry.se3`). Sharing them would let one mistake hide in both the data and the
model that is fitted to it, so nothing here is imported from there, nor the other way about.
"""

import numpy as np

Array = np.ndarray


def rotation_x(angle: float) -> Array:
    """Return the rotation by `angle` [rad] about x, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_y(angle: float) -> Array:
    """Return the rotation by `angle` [rad] about y, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(angle: float) -> Array:
    """Return the rotation by `angle` [rad] about z, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def transform(rotation: Array, translation: Array) -> Array:
    """Return the rigid transform (4, 4) of a rotation (3, 3) and a translation (3,) [m]."""
    T = np.eye(4)
    T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def rotation_from_vector(vector: Array) -> Array:
    """Return the rotation (3, 3) by |vector| [rad] about vector, by Rodrigues' formula in half angles.

    R = I + 2 s c K + 2 s^2 K^2 with K the cross-product matrix of the unit axis, s and c of half the angle:
    exact to rounding for every angle, zero and pi included.
    """
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle / 2), np.cos(angle / 2)
    return np.eye(3) + 2.0 * s * c * K + 2.0 * s * s * (K @ K)


def quaternion_from_rotation(R: Array) -> Array:
    """Return the unit quaternions (..., 4) as (x, y, z, w), w >= 0, of rotations (..., 3, 3).

    Bar-Itzhack's and Shepperd's idea: the four products of the components with the largest one, which is
    never small, so no digits are lost at any angle.
    """
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    wx, wy, wz = R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]
    xy, xz, yz = R[..., 1, 0] + R[..., 0, 1], R[..., 2, 0] + R[..., 0, 2], R[..., 2, 1] + R[..., 1, 2]
    rows = np.stack(
        [
            np.stack([1 + xx - yy - zz, xy, xz, wx], -1),
            np.stack([xy, 1 - xx + yy - zz, yz, wy], -1),
            np.stack([xz, yz, 1 - xx - yy + zz, wz], -1),
            np.stack([wx, wy, wz, 1 + xx + yy + zz], -1),
        ],
        -2,
    )  # row i is 4 q_i q
    largest = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), -1)
    q = np.take_along_axis(rows, largest[..., None, None], -2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., 3:] < 0, -q, q)


def rotation_from_quaternion(q: Array) -> Array:
    """Return the rotations (..., 3, 3) of unit quaternions (..., 4) as (x, y, z, w)."""
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    x, y, z, w = np.moveaxis(q, -1, 0)
    R = np.empty((*q.shape[:-1], 3, 3))
    R[..., 0, 0], R[..., 1, 1], R[..., 2, 2] = (
        1 - 2 * (y * y + z * z),
        1 - 2 * (x * x + z * z),
        1 - 2 * (x * x + y * y),
    )
    R[..., 0, 1], R[..., 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    R[..., 0, 2], R[..., 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    R[..., 1, 2], R[..., 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return R


def vector_from_rotation(R: Array) -> Array:
    """Return the rotation vectors (..., 3) [rad], of length at most pi, of rotations (..., 3, 3)."""
    q = quaternion_from_rotation(R)
    s = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(s, q[..., 3:])
    return np.where(s > 0, q[..., :3] * (angle / np.where(s > 0, s, 1.0)), 2.0 * q[..., :3])


def rpy_from_rotation(R: Array) -> tuple[float, float, float]:
    """Return roll, pitch, yaw [rad] with R = Rz(yaw) Ry(pitch) Rx(roll), as URDF counts them.

    Near a pitch of +-90 degrees (a row of a DH table whose alpha and theta are right angles is exactly there)
    roll and yaw are not determined one by one. Yaw is taken first, and roll from what is left after undoing it,
    so that their errors cancel.
    """
    yaw = float(np.arctan2(R[1, 0], R[0, 0]))
    c, s = np.cos(yaw), np.sin(yaw)
    pitch = float(np.arctan2(-R[2, 0], c * R[0, 0] + s * R[1, 0]))
    roll = float(np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1]))
    return roll, pitch, yaw
