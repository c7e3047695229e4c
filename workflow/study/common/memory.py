"""A simulated scene as the dataset that its folder would be read as, without the folder.

A sweep makes thousands of datasets that nobody opens; written and read back they would be most of its work.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.data.dataset import Dataset, PlaneGuess, Sensor
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import transform_from_rotation_vector

if TYPE_CHECKING:
    from scalar.simulation.scene import SimulatedScene


def dataset_in_memory(scene: SimulatedScene) -> Dataset:
    """Return what ``read_dataset`` would return of the scene's folder, to the digits that its tables keep."""
    mapping = scene.dataset
    sensor = mapping["sensor"]
    nominal = sensor.get("nominal_pose")
    T_flange_sensor = None
    if nominal is not None:
        T_flange_sensor = transform_from_rotation_vector(nominal["translation"], nominal["rotation_vector"])
    n_poses, n_points = scene.points.shape[:2]
    return Dataset(
        name=mapping["name"],
        source=mapping["source"],
        robot=Robot.from_mapping(mapping["robot"]),
        sensor=Sensor(sensor["kind"], T_flange_sensor, sensor.get("noise"), sensor["error_axis"]),
        planes=tuple(
            PlaneGuess(
                name=plane["name"],
                normal=np.array(plane["normal"]) / np.linalg.norm(plane["normal"]),
                distance=float(plane["distance"]) / float(np.linalg.norm(plane["normal"])),
                distance_std=None,
                normal_std=None,
            )
            for plane in mapping["planes"]
        ),
        poses=scene.poses,
        points=scene.points.reshape(-1, 2),
        starts=np.arange(n_poses + 1, dtype=np.int64) * n_points,
    )
