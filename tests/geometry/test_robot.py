"""The chain of joints: frames are products of elementary matrices, standard DH is converted, and every parameter has its screw."""

import numpy as np
import pytest

from scalar.geometry.robot import GEOMETRY, Robot
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS
from tests.robot_configs import ROBOT_CONFIGS, robot_mapping

ROBOTS = sorted(path.stem for path in ROBOT_CONFIGS.glob("*.yaml"))


def random_robot(rng: np.random.Generator, n: int) -> Robot:
    """Return a chain of n joints with random values of every parameter, beta included, and of both fixed transforms."""
    geometry = rng.uniform(-0.5, 0.5, size=(5, n))
    geometry[1] += rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], size=n)
    ends = [kinematics.random_transform(rng, 0.4, 0.9) for _ in range(2)]
    return Robot("any", geometry, np.tile([-np.pi, np.pi], (n, 1)), *ends, np.array([0.0, 0.0, -9.81]))


@pytest.mark.parametrize("name", ROBOTS)
def test_frames_agree_with_elementary_matrices(name):
    """The flange of every robot in configs/ is the product of Rx Tx Ry Rz Tz, joint after joint."""
    mapping = robot_mapping(name)
    robot = Robot.from_mapping(mapping)
    rng = np.random.default_rng(1)
    q = rng.uniform(robot.limits[:, 0], robot.limits[:, 1], size=(50, robot.n_joints))
    geometry = np.array([[joint.get(kind, 0.0) for joint in mapping["joints"]] for kind in PARAMETER_KINDS])
    expected = kinematics.chain(
        geometry, q, kinematics.transform(mapping.get("base"))
    ) @ kinematics.transform(mapping.get("flange"))
    np.testing.assert_allclose(robot.flange(q), expected, atol=2e-15)


@pytest.mark.parametrize("n", [1, 3, 6, 7, 9])
def test_frames_with_all_parameters_and_fixed_transforms(n):
    """The flange is that product for random chains with beta and with transforms before the first joint and after the last."""
    rng = np.random.default_rng(n)
    robot = random_robot(rng, n)
    q = rng.uniform(-3, 3, size=(20, n))
    expected = kinematics.chain(robot.geometry, q, robot.T_base_0) @ robot.T_n_flange
    np.testing.assert_allclose(robot.flange(q), expected, atol=1e-14)
    assert robot.frames(q).shape == (20, n + 1, 4, 4)


def test_offsets_of_the_geometry_act_pose_by_pose():
    """Frames with offsets are those of as many robots with other geometry."""
    rng = np.random.default_rng(3)
    robot = random_robot(rng, 6)
    q = rng.uniform(-3, 3, size=(5, 6))
    offsets = 1e-2 * rng.normal(size=(5, 5, 6))
    frames = robot.frames(q, offsets)
    for i in range(5):
        alone = robot.with_geometry(robot.geometry + offsets[i]).frames(q[i : i + 1])[0]
        np.testing.assert_allclose(frames[i], alone, atol=1e-15)


@pytest.mark.parametrize("n", [2, 6, 7])
def test_standard_dh_is_converted_to_the_same_arm(n):
    """The product of Rz Tz Tx Rx over a standard-DH table, last row included, and the converted chain give the same flange."""
    rng = np.random.default_rng(n)
    rows = [tuple(rng.uniform(-1, 1, size=4)) for _ in range(n)]
    flange = {"translation": [0.1, -0.2, 0.05], "rotation_vector": [0.3, 0.1, -0.7]}
    base = {"translation": [1.0, 2.0, 0.5], "rotation_vector": [0.0, 0.2, 0.4]}
    joints = [{"theta": theta, "d": d, "a": a, "alpha": alpha} for theta, d, a, alpha in rows]
    mapping = {"name": "std", "convention": "standard-dh", "joints": joints, "flange": flange, "base": base}
    robot = Robot.from_mapping(mapping)
    q = rng.uniform(-3, 3, size=(30, n))
    expected = kinematics.transform(base) @ kinematics.standard_chain(rows, q) @ kinematics.transform(flange)
    np.testing.assert_allclose(robot.flange(q), expected, atol=1e-14)
    # Written as modified DH and read again, it is still the same arm.
    again = Robot.from_mapping(robot.to_mapping())
    np.testing.assert_allclose(again.flange(q), expected, atol=1e-14)


def test_standard_dh_cannot_hold_beta():
    """A beta in a standard-DH table is refused, not dropped."""
    with pytest.raises(ValueError, match="beta"):
        Robot.from_mapping({"name": "x", "convention": "standard-dh", "joints": [{"beta": 0.1}]})


def test_ur10e_agrees_with_the_makers_standard_dh():
    """The configured UR10e, modified DH, is the arm of the maker's own standard-DH table."""
    half = np.pi / 2
    rows = [
        (0.0, 0.1807, 0.0, half),
        (0.0, 0.0, -0.6127, 0.0),
        (0.0, 0.0, -0.57155, 0.0),
        (0.0, 0.17415, 0.0, half),
        (0.0, 0.11985, 0.0, -half),
        (0.0, 0.11655, 0.0, 0.0),
    ]
    q = np.random.default_rng(0).uniform(-6, 6, size=(40, 6))
    robot = Robot.from_mapping(robot_mapping("ur10e"))
    np.testing.assert_allclose(robot.flange(q), kinematics.standard_chain(rows, q), atol=1e-14)


def test_mapping_round_trip_keeps_every_number():
    """``from_mapping(to_mapping(robot))`` is the same robot, limits and gravity included."""
    robot = random_robot(np.random.default_rng(5), 7)
    again = Robot.from_mapping(robot.to_mapping())
    np.testing.assert_array_equal(again.geometry, robot.geometry)
    np.testing.assert_array_equal(again.limits, robot.limits)
    np.testing.assert_array_equal(again.gravity, robot.gravity)
    np.testing.assert_allclose(again.T_base_0, robot.T_base_0, atol=1e-15)
    np.testing.assert_allclose(again.T_n_flange, robot.T_n_flange, atol=1e-15)
    assert again.parameter_names == robot.parameter_names


def screw_by_differences(frames_at, h: float = 1e-6) -> np.ndarray:
    """Return the screw ``(N, 6)`` of a motion of frames, by central differences of independent kinematics."""
    plus, minus, middle = frames_at(h), frames_at(-h), frames_at(0.0)
    rate = (plus - minus) / (2 * h) @ np.linalg.inv(middle)
    w = np.stack([rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1)
    return np.concatenate([w, rate[:, :3, 3]], axis=1)


@pytest.mark.parametrize("with_offsets", [False, True])
@pytest.mark.parametrize("n", [3, 7])
def test_screw_of_every_parameter(n, with_offsets):
    """The screw ``dT T^-1`` of the flange by a, alpha, d, theta and beta of every joint agrees with central differences."""
    rng = np.random.default_rng(n)
    robot = random_robot(rng, n)
    q = rng.uniform(-3, 3, size=(4, n))
    offsets = 0.2 * rng.normal(size=(4, 5, n)) if with_offsets else None
    screws = robot.screws(robot.frames(q, offsets), offsets)
    assert screws.shape == (4, 6, 5 * n)
    for column, name in enumerate(robot.parameter_names):
        kind, joint = name.split("_")
        row, i = GEOMETRY.index(kind), int(joint) - 1

        def flange(step, row=row, i=i):
            each = []
            for k in range(4):
                geometry = robot.geometry + (0.0 if offsets is None else offsets[k])
                geometry[row, i] += step
                each.append(kinematics.chain(geometry, q[k : k + 1], robot.T_base_0)[0] @ robot.T_n_flange)
            return np.array(each)

        np.testing.assert_allclose(
            screws[:, :, column], screw_by_differences(flange), atol=3e-9, err_msg=name
        )


def test_screw_of_a_joint_angle_is_that_of_theta():
    """q and theta enter as a sum, so they have the same screw."""
    rng = np.random.default_rng(9)
    robot = random_robot(rng, 6)
    q = rng.uniform(-3, 3, size=(4, 6))
    screws = robot.screws(robot.frames(q))
    for i in range(6):

        def flange(step, i=i):
            return (
                kinematics.chain(robot.geometry, q + step * np.eye(6)[i], robot.T_base_0) @ robot.T_n_flange
            )

        np.testing.assert_allclose(screws[:, :, 18 + i], screw_by_differences(flange), atol=3e-9)
