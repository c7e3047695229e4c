"""Errors of a calibration against the truth, by equations 17 and 18 of the paper at many random poses, raw and aligned.

``T_err = T_true^-1 T_hat``: the position error is the length of its translation, the orientation error the angle of its rotation.
Measurements of planes do not determine the base frame of the robot, so the errors are reported twice: *raw*, of the poses as predicted,
and *aligned*, after the rigid motion of the base that fits the predicted positions best to the true ones. The aligned orientation error
is taken after the same motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from scalar.estimation.result import Calibration
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array, exp_so3, inverse, nearest_rotation, rotation_angle, transform
from scalar.units import DEG, MM


@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Errors at N poses.

    Attributes:
        position: ``(N,)`` [m], distance between predicted and true origin of the sensor.
        orientation: ``(N,)`` [rad], angle of the rotation between predicted and true sensor frame.
    """

    position: Array
    orientation: Array

    def to_mapping(self) -> dict[str, float]:
        """Return mean and maximum of both in millimetres and degrees."""
        return {
            "position_mean_mm": float(self.position.mean() / MM),
            "position_max_mm": float(self.position.max() / MM),
            "orientation_mean_deg": float(self.orientation.mean() / DEG),
            "orientation_max_deg": float(self.orientation.max() / DEG),
        }


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Errors of a calibration against the truth.

    Attributes:
        raw: Errors of the poses as predicted.
        aligned: Errors after the best rigid motion of the base.
        predicted_position_std: ``(N,)`` [m], the standard deviation of each predicted position by the calibration's own covariance.
        planes: One row for each plane, with the errors of normal and distance; empty if the truth has no planes.
        parameters: One row for each parameter, with estimate, truth, error and standard error; empty if the truth has no parameters.
    """

    raw: PoseErrors
    aligned: PoseErrors
    predicted_position_std: Array
    planes: pd.DataFrame
    parameters: pd.DataFrame

    def to_mapping(self) -> dict[str, Any]:
        """Return the numbers as ``evaluation.json`` holds them."""
        return {
            "format": "scalar-evaluation/1",
            "poses": len(self.raw.position),
            "raw": self.raw.to_mapping(),
            "aligned": self.aligned.to_mapping(),
            "predicted_position_std_mean_mm": float(self.predicted_position_std.mean() / MM),
            "planes": self.planes.to_dict("records"),
            "parameters": self.parameters.to_dict("records"),
        }


def true_frames(truth_poses: pd.DataFrame) -> Array:
    """Return the true sensor frames ``(N, 4, 4)`` of a table with x, y, z [m] and rx, ry, rz [rad]."""
    return transform(
        exp_so3(truth_poses[["rx", "ry", "rz"]].to_numpy(dtype=float)),
        truth_poses[["x", "y", "z"]].to_numpy(dtype=float),
    )


def pose_errors(T_true: Array, T_hat: Array) -> PoseErrors:
    """Return the errors of ``T_true^-1 T_hat``, both ``(N, 4, 4)``."""
    difference = inverse(T_true) @ T_hat
    return PoseErrors(np.linalg.norm(difference[:, :3, 3], axis=1), rotation_angle(difference[:, :3, :3]))


def best_rigid_motion(points_from: Array, points_to: Array) -> Array:
    """Return the rigid motion ``(4, 4)`` of least squares that takes points ``(N, 3)`` to others (Kabsch, 1976)."""
    mean_from, mean_to = points_from.mean(axis=0), points_to.mean(axis=0)
    R = nearest_rotation((points_to - mean_to).T @ (points_from - mean_from))
    return transform(R, mean_to - R @ mean_from)


def aligned_to(T_true: Array, T_hat: Array) -> Array:
    """Return predicted frames ``(N, 4, 4)`` after the rigid motion of the base that fits their positions best to the true ones.

    Args:
        T_true: True frames ``(N, 4, 4)`` in the base frame [m].
        T_hat: Predicted frames ``(N, 4, 4)`` in the base frame [m].
    """
    return best_rigid_motion(T_hat[:, :3, 3], T_true[:, :3, 3]) @ T_hat


def evaluate(
    calibration: Calibration, truth_poses: pd.DataFrame, truth: Mapping[str, Any] | None = None
) -> Evaluation:
    """Return the errors of a calibration.

    Args:
        calibration: The calibration to evaluate.
        truth_poses: q1..qn [rad] and the true x, y, z [m], rx, ry, rz [rad] of the sensor in the base frame.
        truth: Content of ``truth.json``, for planes and parameters; or None.
    """
    T_true = true_frames(truth_poses)
    T_hat = calibration.predict(truth_poses)
    return Evaluation(
        raw=pose_errors(T_true, T_hat),
        aligned=pose_errors(T_true, aligned_to(T_true, T_hat)),
        predicted_position_std=calibration.predict_std(truth_poses)[0],
        planes=_plane_errors(calibration, truth),
        parameters=_parameter_errors(calibration, truth),
    )


def _plane_errors(calibration: Calibration, truth: Mapping[str, Any] | None) -> pd.DataFrame:
    target = calibration.model.target
    planes = None if truth is None else truth.get("planes")
    if planes is None or not isinstance(target, Planes):
        return pd.DataFrame()
    normals = np.array(planes["normals"], dtype=float)
    distances = np.array(planes["distances"], dtype=float)
    # A truth without names lists its planes in the order of the dataset, which is that of a calibration with one session.
    names = planes.get("names") or list(target.names)
    rows = []
    for name, normal, distance in zip(target.names, target.normals, target.distances, strict=True):
        if name not in names or names.index(name) >= len(normals):
            continue
        k = names.index(name)
        n_true = normals[k] / np.linalg.norm(normals[k])
        sign = 1.0 if normal @ n_true >= 0 else -1.0
        angle = np.arctan2(np.linalg.norm(np.cross(normal, n_true)), sign * (normal @ n_true))
        rows.append(
            {
                "plane": name,
                "normal_error_deg": float(angle / DEG),
                "distance_error_mm": float((distance - sign * distances[k]) / MM),
            }
        )
    return pd.DataFrame(rows)


def true_parameters(truth: Mapping[str, Any]) -> dict[str, float]:
    """Return the true value [m, rad] of every parameter that ``truth.json`` gives, by name; angles are not wrapped to one turn."""
    values: dict[str, float] = {}
    parameters = truth.get("parameters", {})
    for kind in GEOMETRY:
        values.update({f"{kind}_{i + 1}": float(x) for i, x in enumerate(parameters.get(kind, []))})
    values.update(
        {f"sensor_{axis}": float(x) for axis, x in zip("xyz", parameters.get("t", []), strict=False)}
    )
    values.update(
        {f"sensor_r{axis}": float(x) for axis, x in zip("xyz", parameters.get("r", []), strict=False)}
    )
    return values


_SENSOR_ROTATION = ("sensor_rx", "sensor_ry", "sensor_rz")


def rotation_vector_near(turn: Array, near: Array) -> Array:
    """Return a rotation vector ``(3,)`` [rad] of the same rotation as ``turn``: of two, the one nearer to ``near``.

    ``turn`` and ``turn (1 - 2 pi / |turn|)`` are the same rotation. At half a turn, as of the paper's scanner, they are equally long, and
    it is chance which of the two a fit returns.
    """
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return turn
    other = turn * (1.0 - 2.0 * np.pi / angle)
    return other if np.linalg.norm(other - near) < np.linalg.norm(turn - near) else turn


def _parameter_errors(calibration: Calibration, truth: Mapping[str, Any] | None) -> pd.DataFrame:
    if truth is None:
        return pd.DataFrame()
    true = true_parameters(truth)
    values = dict(zip(calibration.model.names, calibration.model.vector, strict=True))
    if all(name in true for name in _SENSOR_ROTATION):
        near = np.array([true[name] for name in _SENSOR_ROTATION])
        turn = rotation_vector_near(calibration.model.sensor_rotation_vector(), near)
        values.update(zip(_SENSOR_ROTATION, turn, strict=True))
    rows = []
    for name, entry in calibration.parameters().items():
        if name not in true:
            continue
        error = float(values[name] - true[name])
        if entry["unit"] == "rad" and not name.startswith("sensor_"):
            error = float((error + np.pi) % (2 * np.pi) - np.pi)
        rows.append(
            {
                "parameter": name,
                "unit": entry["unit"],
                "value": float(values[name]),
                "truth": true[name],
                "error": error,
                "std": entry["std"],
                "held": entry["held"],
            }
        )
    return pd.DataFrame(rows)
