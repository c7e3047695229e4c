"""The joints that all count the other way in the mirror image of an arm."""

import copy

import numpy as np
import pytest

from scalar.estimation.setup.alternatives import with_sign_changed
from scalar.estimation.setup.mirror_image import mirrored_joints, or_wrong_signs
from scalar.geometry.robot import Robot
from scalar.robots.library import arm_names, read_arm
from tests.robot_configs import robot_mapping


@pytest.mark.parametrize("name", arm_names())
def test_measurements_in_a_mirror_look_like_wrong_signs_of_these_joints(name):
    """Distances between points of the flange in a mirror are those of the arm with the signs changed, and a rotation takes one set to the other."""
    robot = Robot.from_mapping(read_arm(name).mapping)
    joints = mirrored_joints(robot)
    if not joints:
        assert or_wrong_signs(robot) == ""
        return
    changed = robot
    for joint in joints:
        changed = with_sign_changed(changed, joint - 1)
    q = np.random.default_rng(5).uniform(-1, 1, (12, robot.n_joints))
    mirrored = robot.flange(q)[:, :3, 3] * [-1.0, 1.0, 1.0]
    seen = changed.flange(q)[:, :3, 3]
    a, b = mirrored - mirrored.mean(axis=0), seen - seen.mean(axis=0)
    U, sizes, Vt = np.linalg.svd(a.T @ b)
    handed = np.sign(np.linalg.det(U @ Vt)) if sizes[2] > 1e-9 * sizes[0] else 1.0
    R = U @ np.diag([1.0, 1.0, handed]) @ Vt
    np.testing.assert_allclose(a @ R, b, atol=1e-9)


def test_an_arm_without_a_plane_of_symmetry_has_none():
    """An arm whose axes are askew by odd angles is not its own mirror image, and nothing is added to a remedy."""
    mapping = copy.deepcopy(robot_mapping("vs060"))
    for k, joint in enumerate(mapping["joints"]):
        joint["alpha"] = joint["alpha"] + 0.1 * (k + 1)
        joint["d"] = joint["d"] + 0.02 * k
    robot = Robot.from_mapping(mapping)
    assert mirrored_joints(robot) == () and or_wrong_signs(robot) == ""
