"""pybullet's forward kinematics, which is the truth, against computations that share nothing with it."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from scalar.data.io.plain_yaml import load_yaml
from scalar.geometry.robot import Robot
from scalar.simulation.arm import arm_from_mapping, arm_mapping
from scalar.simulation.transforms import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    rotation_x,
    rotation_y,
    rotation_z,
    rpy_from_rotation,
    vector_from_rotation,
)
from scalar.simulation.world import World
from tests.simulation.geometry import sensor_frames

ROBOTS = sorted((Path(__file__).parents[2] / "configs" / "robots").glob("*.yaml"))
SENSOR = {"translation": [-0.1275, -0.033, 0.1015], "rotation_vector": [0.3, -0.2, 2.9]}
POSTURES = 200

# Where the flange is at q = 0, from the makers' drawings and interface documents: (x, y, z) [m].
FLANGE_AT_ZERO = {
    "large_arm": (0.35 + 1.2 + 0.215, 0.0, 0.675 + 1.15 - 0.041),  # upper arm upright, forearm level
    "small_arm": (0.12 + 0.07, 0.0, 0.135 + 0.135 + 0.038),
    "panda": (0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107),
    "puma560": (0.4318 + 0.0203, 0.1501, -0.4331 - 0.05625),  # upper arm level, forearm down
    "ur10e": (-1.18425, -0.2907, 0.06085),
    "vs060": (-0.01, 0.0, 0.345 + 0.305 + 0.3 + 0.07),  # upright
}


def perturbed_arm(path, rng):
    """Return the arm of a robot file with every parameter, beta too, somewhat off."""
    arm = arm_from_mapping(load_yaml(path), SENSOR)
    errors = {name: rng.normal(0, 0.01, arm.n) for name in ("a", "d", "alpha", "theta", "beta")}
    return arm.shifted(errors | {"t": rng.normal(0, 0.01, 3), "r": rng.normal(0, 0.1, 3)})


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
@pytest.mark.parametrize("exact", [True, False], ids=["nominal", "perturbed"])
def test_pybullet_agrees_with_scipy_rotations(path, exact):
    """For any chain, beta included, pybullet's sensor frame is the product of the elementary transforms."""
    rng = np.random.default_rng(1)
    arm = arm_from_mapping(load_yaml(path), SENSOR) if exact else perturbed_arm(path, rng)
    q = rng.uniform(arm.limits[:, 0], arm.limits[:, 1], (POSTURES, arm.n))
    with World() as world:
        world.place_arm(arm)
        T = world.sensor_frames(q)
    np.testing.assert_allclose(T, sensor_frames(arm, q), atol=1e-12, rtol=0)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_pybullet_agrees_with_the_estimator(path):
    """The kinematics that is fitted and the one that makes the data are the same function of q."""
    rng = np.random.default_rng(2)
    arm = perturbed_arm(path, rng)
    q = rng.uniform(arm.limits[:, 0], arm.limits[:, 1], (POSTURES, arm.n))
    with World() as world:
        world.place_arm(arm)
        T = world.sensor_frames(q)
    robot = Robot.from_mapping(arm_mapping(arm))
    np.testing.assert_allclose(T, robot.flange(q) @ arm.T_flange_sensor, atol=1e-12, rtol=0)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_prefilter_kinematics_is_that_of_pybullet(path):
    """The NumPy chain that discards candidates puts the sensor where pybullet puts it."""
    rng = np.random.default_rng(3)
    arm = perturbed_arm(path, rng)
    q = rng.uniform(arm.limits[:, 0], arm.limits[:, 1], (POSTURES, arm.n))
    with World() as world:
        world.place_arm(arm)
        T = world.sensor_frames(q)
    R, origin = arm.sensor_frames(q)
    np.testing.assert_allclose(R, T[:, :3, :3], atol=1e-12, rtol=0)
    np.testing.assert_allclose(origin, T[:, :3, 3], atol=1e-12, rtol=0)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_flange_at_zero_is_where_the_maker_draws_it(path):
    """At q = 0 each arm stands as in its maker's drawing."""
    arm = arm_from_mapping(load_yaml(path), None)
    with World() as world:
        world.place_arm(arm)
        T = world.sensor_frames(np.zeros((1, arm.n)))
    np.testing.assert_allclose(T[0, :3, 3], FLANGE_AT_ZERO[path.stem], atol=1e-12, rtol=0)


def test_standard_dh_is_converted():
    """The UR10e in its maker's standard DH is the UR10e of our file."""
    ours = load_yaml(next(path for path in ROBOTS if path.stem == "ur10e"))
    a = (0, -0.6127, -0.57155, 0, 0, 0)
    d = (0.1807, 0, 0, 0.17415, 0.11985, 0.11655)
    alpha = np.array([1, 0, 0, 1, -1, 0]) * np.pi / 2
    joints = [{"a": a[i], "alpha": alpha[i], "d": d[i], "theta": 0.0} for i in range(6)]
    standard = arm_from_mapping({"name": "ur10e", "convention": "standard-dh", "joints": joints}, None)
    q = np.random.default_rng(4).uniform(-3, 3, (20, 6))
    np.testing.assert_allclose(
        sensor_frames(standard, q), sensor_frames(arm_from_mapping(ours, None), q), atol=1e-14, rtol=0
    )


angles = st.floats(-7, 7) | st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, np.pi / 2 + 1e-9, 1e-9])


@given(angles, angles, angles)
def test_roll_pitch_yaw_gives_the_rotation_back(alpha, beta, theta):
    """Rz(yaw) Ry(pitch) Rx(roll) is the rotation that was taken apart, near a pitch of 90 degrees as well."""
    R = rotation_x(alpha) @ rotation_y(beta) @ rotation_z(theta)
    roll, pitch, yaw = rpy_from_rotation(R)
    np.testing.assert_allclose(rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll), R, atol=5e-15, rtol=0)


@given(st.lists(st.floats(-4, 4), min_size=3, max_size=3))
def test_rotations_agree_with_scipy(vector):
    """Rotation vectors, quaternions and matrices convert as SciPy converts them, at every angle."""
    R = rotation_from_vector(np.array(vector))
    np.testing.assert_allclose(R, Rotation.from_rotvec(vector).as_matrix(), atol=1e-14, rtol=0)
    np.testing.assert_allclose(rotation_from_quaternion(quaternion_from_rotation(R)), R, atol=1e-14, rtol=0)
    back = vector_from_rotation(R)
    assert np.linalg.norm(back) <= np.pi + 1e-14
    np.testing.assert_allclose(rotation_from_vector(back), R, atol=1e-14, rtol=0)
