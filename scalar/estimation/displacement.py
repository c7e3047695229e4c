"""How predicted positions move with the parameters of a model, apart from a motion of the base or of the sensor, which every workcell sets anew.

The place of the base is a convention that neither planes nor a tracker determine, so predictions are compared after the rigid motion of the base
that brings them nearest to each other.
"""

from __future__ import annotations

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array, skew


def kinematics_at(model: Model, poses: Poses) -> Kinematics:
    """Return the kinematics of a model with its effects at any poses."""
    return Kinematics.of(model, poses, EffectBases.of(model.nominal, poses, model.effects))


def shifts(kinematics: Kinematics, screws: Array) -> Array:
    """Return the derivatives ``(3 N, P)`` [m per unit] of the sensor's origins, from the screws ``(N, 6, P)`` of P parameters."""
    o = kinematics.T_base_sensor[:, :3, 3]
    return (screws[:, 3:] - skew(o) @ screws[:, :3]).reshape(3 * len(o), -1)


def position_std(columns: Array, covariance: Array) -> float:
    """Return the standard error of a predicted position [m], root mean square over K poses.

    Args:
        columns: ``(3 K, P)``, derivatives of the positions [m] by the parameters.
        covariance: ``(P, P)``, of the parameters.
    """
    return float(np.sqrt(np.sum((columns @ covariance) * columns) / (len(columns) / 3)))


def displacement_columns(model: Model, poses: Poses) -> Array:
    """Return the derivatives ``(3 N, P)`` of predicted positions [m] by all P parameters.

    From each column, the rigid motion of the base that fits it best is subtracted.
    """
    kinematics = kinematics_at(model, poses)
    return without_rigid_motion(kinematics.T_base_sensor, shifts(kinematics, kinematics.screws()))


def stretch_of(model: Model, poses: Poses) -> float:
    """Return how far predicted positions move [m] per share by which all lengths of the arm grow, root mean square over the poses.

    The rigid motion of the base that fits this best is subtracted.
    """
    T = kinematics_at(model, poses).T_base_sensor
    column = (T[:, :3, 3] - model.nominal.T_base_0[:3, 3]).reshape(-1, 1)
    return position_std(without_rigid_motion(T, column), np.eye(1))


def without_rigid_motion(T: Array, columns: Array) -> Array:
    """Return columns ``(3 N, k)`` of displacements [m] less the rigid motion of the base that fits each best, at frames ``(N, 4, 4)``."""
    basis = np.linalg.qr(base_and_sensor_columns(T)[:, :6])[0]
    return columns - basis @ (basis.T @ columns)


def base_and_sensor_columns(T: Array) -> Array:
    """Return the derivatives ``(3 N, 9)`` of positions by a small motion of the base (rotation, shift) and a shift of the sensor on its flange.

    Args:
        T: ``(N, 4, 4)``, the sensor in the base frame.
    """
    o = T[:, :3, 3]
    moved = np.broadcast_to(np.eye(3), (len(o), 3, 3))
    return np.concatenate([-skew(o), moved, T[:, :3, :3]], axis=2).reshape(3 * len(o), 9)


def projected_out(nuisance: Array, columns: Array, tolerance: float) -> Array:
    """Return ``columns`` with the span of ``nuisance`` projected out.

    Args:
        nuisance: ``(R, J)``, of any rank.
        columns: ``(R, K)``.
        tolerance: Share of the largest singular value of ``nuisance``; directions with a smaller one do not count.
    """
    basis, sizes, _ = np.linalg.svd(nuisance, full_matrices=False)
    basis = basis[:, sizes > tolerance * sizes[0]]
    return columns - basis @ (basis.T @ columns)
