"""Turn a simulated scene into a dataset without writing files.

A sweep makes thousands of datasets that nobody opens; writing them and reading them back would take most of its time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import transform_from_rotation_vector

if TYPE_CHECKING:
    from scalar.simulation.scene import SimulatedScene


def dataset_in_memory(scene: SimulatedScene) -> Dataset:
    """Return what ``read_dataset`` would return for the folder of a scene, but for the rounding of the numbers in its tables."""
    mapping, poses = scene.dataset, scene.poses
    robot, sensor = Robot.from_mapping(mapping["robot"]), mapping["sensor"]
    nominal = sensor.get("nominal_pose")
    T_flange_sensor = None
    if nominal is not None:
        T_flange_sensor = transform_from_rotation_vector(nominal["translation"], nominal["rotation_vector"])
    joints = [f"q{i + 1}" for i in range(robot.n_joints)]
    others = [name for name in poses.columns if name not in ("pose", "plane", *joints)]
    return Dataset.from_arrays(
        robot=robot,
        sensor=Sensor(sensor["kind"], T_flange_sensor, sensor.get("noise"), sensor["error_axis"]),
        q=poses[joints].to_numpy(),
        points=scene.points
        if scene.seen.all()
        else [p[s] for p, s in zip(scene.points, scene.seen, strict=True)],
        planes=[PlaneGuess.from_mapping(plane) for plane in mapping["planes"]],
        plane=list(poses["plane"]),
        columns={name: poses[name].to_numpy() for name in others},
        pose_ids=poses["pose"].to_numpy(),
        name=mapping["name"],
        source=mapping["source"],
    )
