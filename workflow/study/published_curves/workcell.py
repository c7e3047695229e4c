"""Linearise one simulated workcell at the truth: compute how errors of measured points change the calibrated poses.

Near the optimum the fit is linear: errors e [m] of the distances from the planes shift the parameters by
``K e`` with ``K = (J' J)^-1 J'`` (every point has the same weight, as in the original paper), and the poses by ``D K e``. The displacements
that an effect causes are therefore proportional to its size, and no fit is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from study.common.bound import true_model
from study.common.in_memory import dataset_in_memory


@dataclass(frozen=True, eq=False)
class Workcell:
    """A workcell of N poses with M points in a scan, without noise.

    Attributes:
        dataset: The simulated dataset.
        model: The model at the true parameters.
        planes: The true planes.
        free: ``(C,)`` bool, which of the model's C coordinates are estimated; their number is F.
        J: ``(N, M, F)``, derivatives of the points' distances from the planes [m] by the free coordinates.
        by_joint: ``(N, M, n)`` [m/rad], derivatives of the distances by the joint angles.
        incidence: ``(N, M)``, n . u: the plane's normal times the direction of each ray.
        ranges: ``(N, M)``, range of each ray [m].
        plane: ``(N,)``, index of each pose's plane.
        D: ``(P, 6, F)``, derivatives of rotation [rad] and translation [m] of the evaluation poses by the free coordinates.
        evaluated: The P evaluation poses.
        T_true: ``(P, 4, 4)``, true frames of the sensor in the base frame at the evaluation poses.
    """

    dataset: Dataset
    model: Model
    planes: Planes
    free: Array
    J: Array
    by_joint: Array
    incidence: Array
    ranges: Array
    plane: Array
    D: Array
    evaluated: pd.DataFrame
    T_true: Array


def simulate_workcell(config: Mapping[str, Any], base_dir: Path, poses: int) -> Workcell:
    """Return the workcell that a scene describes, without noise.

    Args:
        config: Complete config of the scene.
        base_dir: Folder from which the path of the scene's robot starts.
        poses: Number of evaluation poses.

    Raises:
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.scene import simulate

    fixed = config.get("initial_model", {}).get("exact", ())
    scene = simulate({**config, "noise": {}, "truth_poses": poses}, base_dir=base_dir)
    dataset = dataset_in_memory(scene)
    model = true_model(dataset, scene.truth)
    free = candidate_mask(model, fixed)
    own = Poses.from_frame(dataset.poses, dataset.robot.slides, order_is_row=True)
    kinematics = Kinematics.of(model, own, EffectBases.of(model.nominal, own, ()))
    index = dataset.plane_index.astype(np.intp)
    planes = model.target
    if not isinstance(planes, Planes):
        raise TypeError("scans of planes are needed")
    J = _distance_derivatives(model, planes, kinematics, scene.points, index)
    first = list(model.names).index("theta_1")
    T = kinematics.T_base_sensor
    rays = np.stack([np.sin(scene.angles), np.zeros_like(scene.angles), np.cos(scene.angles)], axis=-1)
    at = Poses.from_frame(scene.truth_poses, dataset.robot.slides, order_is_row=False)
    there = Kinematics.of(model, at, EffectBases.of(model.nominal, at, ()))
    D = there.screws()
    D[:, 3:] += np.cross(D[:, :3], there.T_base_sensor[:, :3, 3, None], axis=1)
    return Workcell(
        dataset=dataset,
        model=model,
        planes=planes,
        free=free,
        J=J[..., free],
        by_joint=J[..., first : first + dataset.robot.n_joints],
        incidence=np.einsum("ni,nij,nmj->nm", planes.normals[index], T[:, :3, :3], rays),
        ranges=scene.ranges,
        plane=index,
        D=D[..., free],
        evaluated=scene.truth_poses,
        T_true=there.T_base_sensor,
    )


def _distance_derivatives(
    model: Model, planes: Planes, kinematics: Kinematics, points: Array, index: Array
) -> Array:
    """Return the derivatives ``(N, M, C)`` of the distances n . p - d of points [m] by all coordinates of the model.

    They are n . (w x p + v) for a coordinate that moves the sensor by the screw (w, v), and those by the planes' own coordinates.

    Args:
        model: The model.
        planes: Its planes.
        kinematics: The model's kinematics at the N poses.
        points: ``(N, M, 2)`` [m], x and z of each point in the sensor frame.
        index: ``(N,)``, index of each pose's plane.
    """
    T, n = kinematics.T_base_sensor, planes.normals[index]
    p = np.einsum("nij,nmj->nmi", T[:, :3, [0, 2]], points) + T[:, None, :3, 3]
    screws = kinematics.screws()
    J = np.cross(p, n[:, None, :]) @ screws[:, :3] + np.einsum("ni,nic->nc", n, screws[:, 3:])[:, None, :]
    tangents, start = planes.normal_derivatives, model.blocks["target"].start
    for row, plane in enumerate(index):
        at = start + 3 * plane
        J[row, :, at : at + 2] = p[row] @ tangents[plane]
        J[row, :, at + 2] = -1.0
    return J


def first_poses(workcell: Workcell, poses: int) -> Array:
    """Return the indices ``(poses,)`` of the first poses of every plane, equally many of each plane.

    The result is shorter if the number of planes does not divide ``poses``.
    """
    planes = np.unique(workcell.plane)
    each = [np.flatnonzero(workcell.plane == k)[: poses // len(planes)] for k in planes]
    return np.sort(np.concatenate(each))


@dataclass(frozen=True, eq=False)
class Shifts:
    """Displacements ``(R, F)`` of the free coordinates by errors of unit standard deviation, in R draws.

    Attributes:
        point: By independent errors of 1 m of each point along its ray.
        scan: By errors of 1 m that are common to all points of a scan.
        joint: By independent errors of 1 rad of every joint of every pose.
        rounded: ``{(sigma, step): displacements}``, by rounding ranges with noise sigma [m] to a step [m]; the displacements by the noise itself
            are not contained.
    """

    point: Array
    scan: Array
    joint: Array
    rounded: dict[tuple[float, float], Array]


def shifts(
    workcell: Workcell,
    design: tuple[int, int],
    sigmas: Sequence[float],
    steps: Sequence[float],
    draws: int,
    rng: np.random.Generator,
) -> Shifts:
    """Return the displacements by unit errors for a part of a workcell: its first poses of every plane, and random points of each scan.

    Args:
        workcell: The whole workcell.
        design: Number of poses on all planes together, and number of points in a scan.
        sigmas: Stated noises [m].
        steps: Steps to which ranges are rounded [m].
        draws: The number R of draws.
        rng: Draws the points of each scan, and the noise.
    """
    poses, M = design
    rows = first_poses(workcell, poses)
    chosen = np.sort(np.argsort(rng.random((len(rows), workcell.ranges.shape[1])), axis=1)[:, :M], axis=1)
    J = np.take_along_axis(workcell.J[rows], chosen[..., None], axis=1)
    by_joint = np.take_along_axis(workcell.by_joint[rows], chosen[..., None], axis=1)
    w = np.take_along_axis(workcell.incidence[rows], chosen, axis=1)
    ranges = np.take_along_axis(workcell.ranges[rows], chosen, axis=1)
    A = J.reshape(-1, J.shape[-1])
    scale = np.linalg.norm(A, axis=0)
    Q, R = np.linalg.qr(A / scale)
    K = np.linalg.solve(R, Q.T) / scale[:, None]

    noise = rng.standard_normal((draws, *w.shape))
    common = rng.standard_normal((draws, len(rows)))
    joint_errors = rng.standard_normal((draws, len(rows), by_joint.shape[-1]))

    def displacements(errors: Array) -> Array:
        """Return the displacements ``(R, F)`` of the coordinates by errors of the distances ``(R, N, M)`` [m]."""
        return errors.reshape(draws, -1) @ K.T

    rounded = {}
    for sigma in sigmas:
        measured = ranges + sigma * noise
        for step in steps:
            rounded[sigma, step] = displacements(w * (step * np.round(measured / step) - measured))
    return Shifts(
        point=displacements(w * noise),
        scan=displacements(w * common[..., None]),
        joint=displacements(np.einsum("nmj,rnj->rnm", by_joint, joint_errors)),
        rounded=rounded,
    )
