"""How near poses are to a singularity: how far the joints move for a small shift of the sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.correction.inverse import arm_length, jacobian, takes_whole_poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """How far the joints move for a small shift of the sensor, at N poses.

    Attributes:
        singular_value: ``(N,)``, the smallest singular value of the Jacobian, with lengths in units of ``arm_length``; 0 at a singularity.
        travel: ``(N, n)`` [rad/m; m/m of a joint that slides], the most that each joint moves for a shift of the sensor, over all directions of the
            shift; its orientation is kept where the arm has six joints or more. Infinite at a singularity.
    """

    singular_value: Array
    travel: Array


def sensitivity(model: Model, poses: Poses, q: Array) -> Sensitivity:
    """Return how near poses are to a singularity.

    For a shift d of the sensor the joints move by ``J^+ (0, d)``; the most of joint i over all d of length one is the norm of row i of the
    columns of ``J^+`` that belong to shifts.

    Args:
        model: The calibrated one.
        poses: With the columns that the effects need.
        q: ``(N, n)`` [rad, m], at which the arm stands.

    Raises:
        InvalidInput: A column that an effect needs is missing.
    """
    standing = replace(poses, q=q)
    J = jacobian(Kinematics.of(model, standing, EffectBases.of(model.nominal, standing, model.effects)))
    length = arm_length(model.nominal)
    J = J / np.array([1.0, 1.0, 1.0, length, length, length])[:, None]
    if not takes_whole_poses(J.shape[2]):
        J = J[:, 3:]
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = U[:, -3:, :] / s[:, None, :]
        pseudo_inverse = np.swapaxes(Vt, 1, 2) @ np.swapaxes(shift, 1, 2)
        travel = np.linalg.norm(pseudo_inverse, axis=2) / length
    return Sensitivity(s[:, -1], np.where(np.isnan(travel), np.inf, travel))
