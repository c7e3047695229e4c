"""How far predicted positions move if all lengths of an arm grow by one share, apart from a motion of the base."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.estimation.displacement import stretch_of
from scalar.estimation.model import Model
from scalar.evaluate.pose_errors import best_rigid_motion
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.sensors import measure
from tests.random_scene import make_scene
from tests.turning import turning


def test_a_stretch_moves_positions_as_an_arm_with_longer_links_does():
    """The arm with lengths a thousandth longer, fitted by the best rigid motion, is off by a thousandth of what is stated."""
    dataset = make_scene(kind="probe", seed=3, poses_per_plane=30).dataset
    T_sensor = dataset.sensor.T_flange_sensor
    assert T_sensor is not None
    T_sensor = T_sensor.copy()
    T_sensor[:3, 3] = 0.0  # so that lengths are those of the arm alone
    model = Model.at(dataset.robot, T_sensor, measure(dataset).initial_target(dataset))
    poses = Poses.from_arrays(dataset.q, {}, turning(6))
    lengths = np.array([kind in LENGTHS for kind in GEOMETRY])[:, None]
    robot = replace(dataset.robot, T_n_flange=np.eye(4))
    model = replace(model, robot=robot, nominal=robot)
    longer = replace(robot, geometry=np.where(lengths, 1.001, 1.0) * robot.geometry)
    here = (robot.flange(dataset.q) @ T_sensor)[:, :3, 3]
    there = (longer.flange(dataset.q) @ T_sensor)[:, :3, 3]
    T = best_rigid_motion(there, here)
    off = there @ T[:3, :3].T + T[:3, 3] - here
    assert stretch_of(model, poses) == pytest.approx(1e3 * np.sqrt(np.mean(np.sum(off**2, axis=1))), rel=0.1)
