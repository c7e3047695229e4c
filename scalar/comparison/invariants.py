"""The part of the difference of two calibrations that belongs to the arm, whatever base, sensor and fixed parameters the campaigns had.

From the derivatives of the predicted poses by the arm's parameters (a screw for each pose and parameter), motions of the base and of the
sensor are projected out. Combinations of parameters that then move nothing, such as d of one and -d of the next of two parallel axes, are
null directions G: two fits may differ along them only because different parameters were fixed. Only linear functions Q of the parameters
with ``Q G = 0`` can be compared. Their covariance is ``Q C Q'``, C being that of the difference; functions that neither calibration
estimated are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.comparison.arm_parameters import ArmParameters, effects_of_the_arm, scale_direction
from scalar.data.poses import Poses
from scalar.estimation.displacement import base_and_sensor_columns, kinematics_at, projected_out, shifts
from scalar.estimation.model import Model
from scalar.estimation.random_poses import random_poses
from scalar.geometry.parallel_axes import with_parallel_axes
from scalar.geometry.screws import change_frame
from scalar.geometry.se3 import Array

N_POSES = 300
NEGLIGIBLE = 1e-7  # share of the largest singular value: a combination with a smaller one moves nothing
_NOT_ESTIMATED = 1e-12  # share of the largest variance: neither calibration estimated a function with less
_INCOMPARABLE = 1e-6  # norm of a parameter's column of Q in the estimated functions, at most 1: if it is smaller, none of them depends on it


@dataclass(frozen=True, eq=False)
class Invariants:
    """The comparable functions of the parameters, whitened: R numbers of unit variance.

    Attributes:
        difference: ``(R,)``, their values in B minus those in A.
        response: ``(R, P)``, derivatives of the numbers by the arm's parameters; zero for a parameter that cannot be compared or was fixed in both.
    """

    difference: Array
    response: Array


def invariants(arm: ArmParameters) -> Invariants:
    """Return the functions of the arm's parameters in which two calibrations can be compared, with the difference of the two."""
    poses = random_poses(arm.model, N_POSES)
    columns = _pose_columns(arm.model, poses)[:, arm.columns]
    scale = np.linalg.norm(columns, axis=0) / np.sqrt(len(poses))
    moves = scale > NEGLIGIBLE * scale.max()
    scale[~moves] = 1.0
    _, s, Vt = np.linalg.svd(np.linalg.qr(columns * (moves / scale), mode="r"))
    null_directions = [*Vt[s < NEGLIGIBLE * s[0]]]
    if arm.scale_unknown:
        along = np.zeros(len(arm.names))
        geometry = scale_direction(arm.model)
        along[: len(geometry)] = geometry
        null_directions.append(along * scale)
    null_directions += [
        row for row, name in zip(np.eye(len(arm.names)), arm.names, strict=True) if name in arm.unknown
    ]
    Q = _orthogonal_complement(np.array(null_directions).reshape(-1, len(arm.names)))
    variance = Q @ (arm.covariance * np.outer(scale, scale)) @ Q.T
    values, vectors = np.linalg.eigh(variance)
    estimated = values > _NOT_ESTIMATED * values.max(initial=0.0)
    functions = vectors[:, estimated].T @ Q
    response = functions / np.sqrt(values[estimated])[:, None]
    # A parameter that both calibrations fixed to choose a frame may still move predictions a little, if an effect tilts that frame.
    comparable = np.linalg.norm(functions, axis=0) > _INCOMPARABLE
    comparable &= ~arm.fixed_in_both
    return Invariants(response @ (arm.difference * scale), response * (comparable * scale))


def displacement_columns(arm: ArmParameters) -> Array:
    """Return the derivatives ``(3 K, P)`` [m per unit] of the predicted positions at random poses by the arm's parameters.

    From each column, the motion of the base and the shift of the sensor on its flange that fit it best are subtracted. K is ``N_POSES``.
    """
    kinematics = kinematics_at(arm.model, random_poses(arm.model, N_POSES))
    moved = shifts(kinematics, kinematics.screws()[:, :, arm.columns])
    return projected_out(base_and_sensor_columns(kinematics.T_base_sensor), moved, NEGLIGIBLE)


def displacements(a: Model, b: Model) -> Array:
    """Return the positions predicted by model b minus those by model a at K random poses, ``(K, 3)`` [m] in the base frame.

    The motion of the base and the shift of the sensor on its flange that fit the differences best are subtracted. Effects that do not stay with
    the arm are left out. The poses, and the nominal robot at which effects are evaluated, are those of model a.
    """
    poses = random_poses(a, N_POSES)
    T, other = (
        kinematics_at(model, poses).T_base_sensor
        for model in (
            replace(a, effects=effects_of_the_arm(a)),
            replace(b, nominal=a.nominal, effects=effects_of_the_arm(b)),
        )
    )
    moved = (other[:, :3, 3] - T[:, :3, 3]).reshape(-1, 1)
    return projected_out(base_and_sensor_columns(T), moved, NEGLIGIBLE).reshape(-1, 3)


def _pose_columns(model: Model, poses: Poses) -> Array:
    """Return the derivatives ``(6 K, P)`` of K poses by the parameters, with motions of base and sensor projected out.

    A radian counts as a metre, and nearly parallel axes as exactly parallel. The derivatives by the geometry are those of the model without effects:
    an effect that bends the base makes the choice of a frame, which is arbitrary, move poses a little.
    """
    parallel = replace(model, robot=with_parallel_axes(model.robot))
    with_effects, rigid = (_screws_of_arm(one, poses) for one in (parallel, replace(parallel, effects=())))
    geometry = model.blocks["geometry"]
    with_effects[:, geometry] = rigid[:, geometry]
    return with_effects


def _screws_of_arm(model: Model, poses: Poses) -> Array:
    """Return the derivatives ``(6 K, P)`` of K poses by the parameters of a model, with motions of base and sensor projected out."""
    kinematics = kinematics_at(model, poses)
    T = kinematics.T_base_sensor
    eye = np.broadcast_to(np.eye(6), (len(T), 6, 6))
    nuisance = np.concatenate([eye, change_frame(T, eye)], axis=2).reshape(-1, 12)
    return projected_out(nuisance, kinematics.screws().reshape(6 * len(T), -1), NEGLIGIBLE)


def _orthogonal_complement(rows: Array) -> Array:
    """Return orthonormal rows ``(P - r, P)`` orthogonal to all given rows ``(k, P)`` of rank r."""
    if not len(rows):
        return np.eye(rows.shape[1])
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    _, s, Vt = np.linalg.svd(rows / np.where(lengths > 0, lengths, 1.0))
    rank = int(np.sum(s > NEGLIGIBLE * s[0]))
    return Vt[rank:]
