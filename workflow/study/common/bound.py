"""Compute the Cramér-Rao bound as pose errors: those of an unbiased estimator with the smallest possible covariance.

At the truth the covariance of every unbiased estimate of the free parameters is at least ``C = (J' J)^-1``, with J the
whitened Jacobian. Parameter errors drawn from N(0, C) move the poses by ``de = v + w x p``, and the mean and maximum of
these position errors are comparable, number by number, with those of a calibration. (The root of the trace of a pose's
covariance is not comparable: it is the root mean square of the error's length, which is about 8 % larger than the mean
length if the error is isotropic.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask
from scalar.estimation.residuals import Residuals
from scalar.evaluate import PoseErrors
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array, transform_from_rotation_vector

DRAWS = 64  # draws of parameter errors: the standard error of the mean pose error is about 2 %
POSES = 2000  # the first of the evaluation poses; the maximum over 10,000 lies about 1 % higher
DRAWS_SEED = 0
_LEAST_SINGULAR_VALUE = 1e-6  # relative to the largest, of the Jacobian with columns of unit length: with a smaller one, a direction is unobservable


def bound_errors(
    dataset: Dataset, truth: Mapping[str, Any], fixed: Sequence[str], truth_poses: pd.DataFrame
) -> tuple[dict[str, float], dict[str, float]] | None:
    """Return the errors expected at the bound, and those of the efficient estimate, with the keys of ``PoseErrors.to_mapping``.

    The efficient estimate is one Gauss-Newton step from the truth, with the noise of the dataset. None is returned if the dataset states no noise,
    or if some direction of the parameters is unobservable.

    Args:
        dataset: What was measured. Its noise decides the efficient estimate; the bound depends on its points only by the incidence of each ray.
        truth: Content of ``truth.json``.
        fixed: Names of the parameters that are not estimated, in addition to Hayati's beta, which is never estimated here.
        truth_poses: Content of ``truth_poses.csv``.
    """
    if dataset.sensor.noise is None:
        return None
    model = true_model(dataset, truth)
    free = candidate_mask(model, fixed)
    residuals = Residuals.of(dataset, model).reweighted(model)
    if int(residuals.measurement.equations.sum()) < int(free.sum()):
        return None  # a compressed scan has three rows, but counts as two equations: the third contains only the noise of its points
    residual, J = residuals.linearise(model)
    J = J[:, free]
    scale = np.linalg.norm(J, axis=0)
    if not scale.all():
        return None
    singular_values = np.linalg.svd(np.linalg.qr(J / scale, mode="r"), compute_uv=False)
    if singular_values[-1] < _LEAST_SINGULAR_VALUE * singular_values[0]:
        return None
    covariance = covariance_and_step(J, np.zeros(len(J)))[0]
    target = model.blocks["target"]
    columns = np.flatnonzero(free)
    moves_sensor = (columns < target.start) | (columns >= target.stop)  # unlike the coordinates of the planes
    values, vectors = np.linalg.eigh(covariance[np.ix_(moves_sensor, moves_sensor)])
    draws = np.random.default_rng(DRAWS_SEED).standard_normal((int(moves_sensor.sum()), DRAWS))
    drawn = (vectors * np.sqrt(np.maximum(values, 0.0))) @ draws
    efficient = -(covariance @ (J.T @ residual))[moves_sensor]
    errors = np.column_stack([drawn, efficient])
    at = Poses.from_frame(truth_poses.head(POSES), model.robot.slides, order_is_row=False)
    kinematics = Kinematics.of(model, at, EffectBases.of(model.nominal, at, model.effects))
    screws = kinematics.screws()[:, :, columns[moves_sensor]] @ errors
    turn, moved = screws[:, :3], screws[:, 3:]
    moved = moved + np.cross(turn, kinematics.T_base_sensor[:, :3, 3, None], axis=1)
    each = [PoseErrors(p, o).to_mapping() for p, o in zip(_lengths(moved), _lengths(turn), strict=True)]
    efficient_errors = each.pop()
    return {name: float(np.mean([one[name] for one in each])) for name in each[0]}, efficient_errors


def true_model(dataset: Dataset, truth: Mapping[str, Any]) -> Model:
    """Return the model of a dataset at the true parameters.

    Args:
        dataset: Gives the nominal robot.
        truth: Content of ``truth.json``.
    """
    parameters, planes = truth["parameters"], truth["planes"]
    robot = dataset.robot.with_geometry(np.array([parameters[kind] for kind in GEOMETRY]))
    target = Planes.at(planes["names"], np.array(planes["normals"]), planes["distances"])
    return Model.at(robot, transform_from_rotation_vector(parameters["t"], parameters["r"]), target)


def _lengths(vectors: Array) -> Array:
    """Return the lengths ``(S, N)`` of vectors ``(N, 3, S)``."""
    return np.sqrt(np.einsum("nis,nis->sn", vectors, vectors))
