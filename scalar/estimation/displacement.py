"""How predicted positions move with the parameters of a model, without what a workcell sets anew: the base, and the sensor on its flange.

The place of the base is a convention that neither planes nor a tracker determine, so predictions are compared after the motion that brings them
nearest to each other.
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
    """Return by how much the sensor's origins move ``(3 N, P)`` [m] with screws ``(N, 6, P)``."""
    o = kinematics.T_base_sensor[:, :3, 3]
    return (screws[:, 3:] - skew(o) @ screws[:, :3]).reshape(3 * len(o), -1)


def displacement_columns(model: Model, poses: Poses) -> Array:
    """Return the derivatives ``(3 N, P)`` of predicted positions [m] by all parameters, the best motion of the base removed from each."""
    kinematics = kinematics_at(model, poses)
    basis = np.linalg.qr(base_and_sensor(kinematics.T_base_sensor)[:, :6])[0]
    shift = shifts(kinematics, kinematics.screws())
    return shift - basis @ (basis.T @ shift)


def base_and_sensor(T: Array) -> Array:
    """Return the derivatives ``(3 N, 9)`` of positions by a small motion of the base (turn, shift) and a shift of the sensor on its flange.

    Args:
        T: ``(N, 4, 4)``, the sensor in the base frame.
    """
    o = T[:, :3, 3]
    moved = np.broadcast_to(np.eye(3), (len(o), 3, 3))
    return np.concatenate([-skew(o), moved, T[:, :3, :3]], axis=2).reshape(3 * len(o), 9)


def without(nuisance: Array, columns: Array, tolerance: float) -> Array:
    """Return columns ``(R, K)`` without what other columns ``(R, J)`` explain of them.

    Args:
        nuisance: Of any rank.
        columns: To be freed of them.
        tolerance: Of the largest singular value: directions below it are none.
    """
    basis, sizes, _ = np.linalg.svd(nuisance, full_matrices=False)
    basis = basis[:, sizes > tolerance * sizes[0]]
    return columns - basis @ (basis.T @ columns)
