"""Predicted minus measured positions, then orientations, of a tracker's targets, with all derivatives.

With ``T_tracker_base = (R, t)``, a target at o in the base frame has the residual ``R o + t - y``, and one with the orientation
``R_base_target`` the rotation vector ``r = log(R R_base_target R_measured^T)``. A small turn w of the target, in the tracker's axes, changes it by
``J_l(r)^-1 w`` (Barfoot, State Estimation for Robotics, 7.85).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.geometry.se3 import Array, cross, left_jacobian_so3, log_so3
from scalar.sensors.tracker_frames import TrackerFrames


def tracked_rows(
    T_base_sensor: Array,
    frames: TrackerFrames,
    index: Array,
    names: Sequence[str],
    positions: Array | None,
    rotations: Array | None,
    *,
    oriented: bool,
) -> tuple[Array, Array, Array]:
    """Return residuals ``(N, m)`` [m, rad], wrenches ``(N, m, 6)`` and derivatives by the coordinates of frame and targets ``(N, m, 6 + common)``.

    A wrench holds the derivatives of a row by a small motion (w, v) of the sensor in the base frame; ``common`` is the number of coordinates of the
    targets on the flange, which all sessions share.

    Args:
        T_base_sensor: ``(N, 4, 4)``.
        frames: The tracker's frames, and the targets on the flange.
        index: ``(N,)``, the session of each pose.
        names: Names of the K measured targets. The rows of a target that the model does not have are zero.
        positions: ``(N, K, 3)`` [m], measured. If None, residuals of positions are zero, as for derivatives where nothing was measured.
        rotations: ``(N, K, 3, 3)``, measured; if None, residuals of orientations are zero.
        oriented: Whether orientations are measured, so that m is 6 K instead of 3 K.
    """
    N, K = len(T_base_sensor), len(names)
    R, targets = frames.rotations[index], frames.targets
    left = np.stack([left_jacobian_so3(r) for r in frames.coordinates[:, 3:]])[index]
    m = K * (6 if oriented else 3)
    residual, wrench = np.zeros((N, m)), np.zeros((N, m, 6))
    by_target = np.zeros((N, m, 6 + frames.common))
    R_tracker_sensor = R @ T_base_sensor[:, :3, :3]
    for k, name in enumerate(names):
        i = targets.index(name)
        if i is None:
            continue
        at = slice(3 * k, 3 * k + 3)
        o = T_base_sensor[:, :3, 3]
        if i > 0:
            o = o + T_base_sensor[:, :3, :3] @ targets.coordinates[i, :3]
        turned = (R @ o[:, :, None])[:, :, 0]
        if positions is not None:
            residual[:, at] = turned + frames.coordinates[index, :3] - positions[:, k]
        wrench[:, at, :3] = cross(np.broadcast_to(o[:, None, :], R.shape), R)
        wrench[:, at, 3:] = R
        by_target[:, at, :3] = np.eye(3)
        # d(exp(r) R0 o) = (J_l dr) x (R o): a column is J_l's column crossed with the turned point.
        columns = cross(np.swapaxes(left, 1, 2), np.broadcast_to(turned[:, None, :], R.shape))
        by_target[:, at, 3:6] = np.swapaxes(columns, 1, 2)
        by_offsets = targets.derivatives(name)
        by_target[:, at, 6:] = R_tracker_sensor @ by_offsets[:3]
        if not oriented:
            continue
        at = slice(3 * (K + k), 3 * (K + k) + 3)
        by_turn = np.broadcast_to(np.eye(3), R.shape)
        if rotations is not None:
            R_target = R_tracker_sensor @ targets.rotations[i]
            residual[:, at] = log_so3(R_target @ np.swapaxes(rotations[:, k], 1, 2))
            by_turn = np.linalg.inv(left_jacobian_so3(residual[:, at]))
        wrench[:, at, :3] = by_turn @ R
        by_target[:, at, 3:6] = by_turn @ left
        by_target[:, at, 6:] = by_turn @ R_tracker_sensor @ by_offsets[3:]
    return residual, wrench, by_target
