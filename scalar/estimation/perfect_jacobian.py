"""The Jacobian of perfect measurements, which satisfy the model exactly.

With noisy measurements, no singular value is exactly zero, and every direction looks slightly observable. For measurements without error, a
direction that leaves the residual unchanged has a singular value as small as the rounding error, however noisy the dataset is.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals, plane_problem
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, by_coordinates


def perfect_jacobian(
    residuals: Residuals, measurement: Measurement, model: Model, poses: Poses, index: Array
) -> Array:
    """Return the Jacobian ``(rows, P)`` of measurements that satisfy the model exactly.

    Args:
        residuals: Of the dataset; states which planes are known as references.
        measurement: The sensor kind's rows.
        model: Without effects.
        poses: With joint angles ``(N, n)`` [rad], near which the perfect measurements are taken.
        index: ``(N,)``, index of the plane or tracker frame that each pose measures.
    """
    J = _of_scans(measurement, model, poses, index)
    if J is None:
        J = _of_any_kind(measurement, model, poses.q, index)
    where = model.blocks["target"]
    if residuals.known is None:
        return J
    known = residuals.known.rows(model.target)[1]  # type: ignore[arg-type]
    below = np.zeros((len(known), J.shape[1]))
    below[:, where] = known / np.abs(known).max()
    return np.vstack([J, below])


def _of_scans(measurement: Measurement, model: Model, poses: Poses, index: Array) -> Array | None:
    """Return the measured rows for scans of planes, by the compiled library; None for other kinds, and without the library."""
    if not measurement.scans or measurement.contact_factors is None:
        return None
    problem = plane_problem(model, poses, index, np.broadcast_to(np.eye(3), (len(poses), 3, 3)))
    if problem is None:
        return None
    c, by = problem.linearise(model.vector)
    scans: Any = measurement  # with contact factors it has perfect ones as well
    factors, usable = scans.perfect_factors(c)
    return (factors @ by)[usable].reshape(-1, by.shape[2])


def _of_any_kind(measurement: Measurement, model: Model, q: Array, index: Array) -> Array:
    """Return the measured rows for any kind of sensor; joint angles are changed first so that every pose is a perfect measurement."""
    none = EffectBases([], [], [], [])

    def kinematics(q: Array) -> Kinematics:
        return Kinematics.of(model, Poses.of_joints(q), none)

    at = kinematics(q)
    moving = np.ptp(q, axis=0) > 0
    for _ in range(measurement.contact_iterations):
        by_joint = at.screws()[:, :, model.robot.joint_columns]
        q = q + measurement.contact_step(at.T_base_sensor, model.target, index, by_joint * moving)
        at = kinematics(q)
    wrench, by_target, usable = measurement.perfect_rows(at.T_base_sensor, model.target, index)
    J = wrench @ at.screws()
    where = model.blocks["target"]
    if by_target.shape[2]:  # a target that is known has no coordinates
        J[:, :, where] = by_coordinates(model.target, by_target, index)
    return J[usable].reshape(-1, J.shape[2])
