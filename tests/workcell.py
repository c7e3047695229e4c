"""A workcell of the tests: the truth, a dataset that was measured in it, and how both are written to files."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.declared import Sensor
from tests.kinematics import PARAMETER_KINDS, chain, joint_names, pose_mapping, rotation_vector

PLANE_NAMES = ("floor", "wall_x", "wall_y")


@dataclass(frozen=True, eq=False)
class Truth:
    """The true workcell.

    Attributes:
        geometry: ``(5, n)``, rows as in ``PARAMETER_KINDS`` [m, rad].
        T_base_0, T_n_flange, T_flange_sensor: ``(4, 4)``.
        limits: ``(n, 2)`` [rad].
        normals, distances: The true target planes ``(K, 3)`` and ``(K,)`` [m] in the base frame; empty for a tracker.
        T_tracker_base: ``(4, 4)``; only a tracker's measurements depend on it.
    """

    geometry: np.ndarray
    T_base_0: np.ndarray
    T_n_flange: np.ndarray
    T_flange_sensor: np.ndarray
    limits: np.ndarray
    normals: np.ndarray
    distances: np.ndarray
    T_tracker_base: np.ndarray

    def sensor(self, q: np.ndarray) -> np.ndarray:
        """Return ``T_base_sensor`` ``(N, 4, 4)`` at joint angles ``(N, n)`` [rad]."""
        return chain(self.geometry, q, self.T_base_0) @ self.T_n_flange @ self.T_flange_sensor

    def parameters(self) -> dict[str, float]:
        """Return the true value of every parameter of robot and sensor by name."""
        n = self.geometry.shape[1]
        values = {
            f"{kind}_{i + 1}": float(self.geometry[k, i])
            for k, kind in enumerate(PARAMETER_KINDS)
            for i in range(n)
        }
        turn = rotation_vector(self.T_flange_sensor[:3, :3])
        values.update(
            {f"sensor_{axis}": float(x) for axis, x in zip("xyz", self.T_flange_sensor[:3, 3], strict=True)}
        )
        values.update({f"sensor_r{axis}": float(x) for axis, x in zip("xyz", turn, strict=True)})
        return values

    def mapping(self) -> dict[str, Any]:
        """Return the content of ``truth.json``."""
        parameters: dict[str, Any] = {
            kind: row.tolist() for kind, row in zip(PARAMETER_KINDS, self.geometry, strict=True)
        }
        parameters["t"] = self.T_flange_sensor[:3, 3].tolist()
        parameters["r"] = rotation_vector(self.T_flange_sensor[:3, :3]).tolist()
        planes = {"names": list(PLANE_NAMES[: len(self.normals)])}
        planes.update(normals=self.normals.tolist(), distances=self.distances.tolist())
        return {"parameters": parameters, "planes": planes, "effects": []}

    def poses(self, count: int, rng: np.random.Generator) -> pd.DataFrame:
        """Return random poses within the limits with the true sensor frames: the table of ``truth_poses.csv``."""
        q = self.limits[:, 0] + rng.random((count, len(self.limits))) * np.ptp(self.limits, axis=1)
        T = self.sensor(q)
        columns = ["pose", *joint_names(q.shape[1]), "x", "y", "z", "rx", "ry", "rz"]
        values = np.column_stack([np.arange(count), q, T[:, :3, 3], rotation_vector(T[:, :3, :3])])
        return pd.DataFrame(values, columns=columns).astype({"pose": int})


@dataclass(frozen=True, eq=False)
class Scene:
    """A dataset with its truth, and how to draw its noise anew without moving anything.

    Attributes:
        dataset: As the calibrator sees it.
        truth: What it does not see.
        clean: The points without noise, as in ``Dataset.points``; empty for a probe, whose noise is in where it touches.
        noise: Standard deviation of a measurement [m], along the direction in which ``with_noise`` adds it.
    """

    dataset: Dataset
    truth: Truth
    clean: np.ndarray
    noise: float

    def redraw(self, rng: np.random.Generator) -> Dataset:
        """Return the dataset with another draw of the noise, from the same poses and rays; a probe's stays as it is."""
        return replace(self.dataset, points=with_noise(self.clean, self.dataset.sensor, self.noise, rng))

    def mapping(self) -> dict[str, Any]:
        """Return the content of dataset.yaml."""
        sensor: dict[str, Any] = {
            "kind": self.dataset.sensor.kind,
            "error_axis": self.dataset.sensor.error_axis,
        }
        if self.dataset.sensor.noise is not None:
            sensor["noise"] = self.dataset.sensor.noise
        if self.dataset.sensor.T_flange_sensor is not None:
            sensor["nominal_pose"] = pose_mapping(self.dataset.sensor.T_flange_sensor)
        robot = self.dataset.robot
        joints = [
            {
                **{kind: float(robot.geometry[k, i]) for k, kind in enumerate(PARAMETER_KINDS)},
                "limits": robot.limits[i].tolist(),
            }
            for i in range(robot.n_joints)
        ]
        mapping: dict[str, Any] = {
            "format": "scalar-dataset/2",
            "name": self.dataset.name,
            "robot": {
                "name": robot.name,
                "convention": "modified-dh",
                "joints": joints,
                "base": pose_mapping(robot.T_base_0),
                "flange": pose_mapping(robot.T_n_flange),
            },
            "sensor": sensor,
        }
        if self.dataset.planes:
            mapping["planes"] = [
                {"name": p.name, "normal": p.normal.tolist(), "distance": float(p.distance)}
                for p in self.dataset.planes
            ]
        return mapping

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables as keywords of ``write_dataset``."""
        data = self.dataset
        tables = {"poses": data.poses}
        if data.sensor.kind == "line-laser":
            ids = np.repeat(data.pose_ids, np.diff(data.starts))
            tables["scans"] = pd.DataFrame({"pose": ids, "x": data.points[:, 0], "z": data.points[:, 1]})
        elif data.sensor.kind == "tracker":
            columns = dict(zip("xyz", data.points.T, strict=True))
            tables["points"] = pd.DataFrame({"pose": data.pose_ids, **columns})
        return tables

    def write(self, folder: Path) -> Path:
        """Write the dataset folder and return its path."""
        write_dataset(folder, mapping=self.mapping(), **self.tables())
        return folder

    def write_truth(self, folder: Path, rng: np.random.Generator, count: int = 500) -> Path:
        """Write the truth folder and return its path."""
        folder.mkdir(parents=True)
        (folder / "truth.json").write_text(json.dumps(self.truth.mapping()), encoding="utf-8")
        self.truth.poses(count, rng).to_csv(folder / "truth_poses.csv", index=False)
        return folder


def with_noise(clean: np.ndarray, sensor: Sensor, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Return points [m] with Gaussian errors along their rays or along z, as ``error_axis`` says, or (tracker) along each axis."""
    if sensor.kind == "tracker":
        return clean + noise * rng.standard_normal(clean.shape)
    along = np.tile([0.0, 1.0], (len(clean), 1))
    if sensor.error_axis == "ray":
        along = clean / np.linalg.norm(clean, axis=1, keepdims=True)
    return clean + noise * rng.standard_normal((len(clean), 1)) * along
