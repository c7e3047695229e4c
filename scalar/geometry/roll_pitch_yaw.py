"""Roll, pitch and yaw, as URDF and ROS have them: ``R = Rz(yaw) Ry(pitch) Rx(roll)``."""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array


def rotation_from_rpy(rpy: Array) -> Array:
    """Return ``Rz(yaw) Ry(pitch) Rx(roll)``, ``(3, 3)``, of ``rpy`` ``(3,)`` [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_from_rotation(R: Array) -> Array:
    """Return roll, pitch and yaw ``(3,)`` [rad] of a rotation ``(3, 3)``, exact near a pitch of 90 degrees too.

    Where the pitch is 90 or -90 degrees, only the sum or the difference of roll and yaw is determined; there roll is zero.
    """
    vertical = np.hypot(R[0, 0], R[1, 0]) < 1e-9
    yaw = np.arctan2(-R[0, 1], R[1, 1]) if vertical else np.arctan2(R[1, 0], R[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    rest = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ R
    return np.array([np.arctan2(-rest[1, 2], rest[1, 1]), np.arctan2(-rest[2, 0], rest[0, 0]), yaw]) + 0.0
