"""Corrections at home poses, which are singular: the arm comes as near as small changes of its joints bring it."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.estimation.correction import CorrectionSettings, brought_near, correct_joints
from scalar.geometry.robot import Robot
from scalar.robots.library import read_arm
from tests.calibrated_arms import calibrated
from tests.turning import turning


def poses_of(q):
    """Return poses of joint angles ``(N, n)`` [rad] alone."""
    return Poses.from_arrays(q, {}, turning(q.shape[1]))


STRAIGHT_WRIST = (
    "abb_irb1200_7_70",
    "ur10e",
    "kuka_lbr_iiwa_7_r800",
    "mecademic_meca500",
    "kinova_gen3_7dof",
    "franka_panda",
)
UPRIGHT = ("denso_vs060", "doosan_m0609", "staubli_tx2_60")
"""Arms of the library whose axes 4 and 6 are in line with all joints at zero, or that are regular there; and arms that are stretched out upwards."""


def at_zero(name):
    """Return the calibration of an arm, the pose with all joints at zero (or at the nearest limit), and its exact correction."""
    robot = Robot.from_mapping(read_arm(name).mapping)
    made = calibrated(robot, np.random.default_rng(1))
    poses = poses_of(np.clip(np.zeros((1, robot.n_joints)), *robot.limits.T))
    return made, poses, correct_joints(made.model, poses)


@pytest.mark.parametrize("name", [*STRAIGHT_WRIST, *UPRIGHT])
def test_a_home_pose_comes_near(name):
    """Small changes take the sensor to within 0.05 mm of its place; of an arm that is stretched out, whose place is at the edge of its reach or
    beyond, they take it nearer. What is stated is where `predict` has the sensor."""
    made, poses, exact = at_zero(name)
    found, given = brought_near(made.model, poses, exact)
    off = np.linalg.norm((made.predict(found.q) - found.T_wanted)[:, :3, 3], axis=1)
    np.testing.assert_allclose(off, found.position_error, atol=1e-12)
    assert off[0] < (5e-5 if name in STRAIGHT_WRIST else given.position_error[0])
    if not found.reached[0]:
        assert np.abs(found.q - poses.q).max() <= CorrectionSettings().small_change
        assert given.position_error[0] > 1e-4


def test_what_is_reached_is_left_alone():
    """If the correction takes the frame exactly, its joint angles stay as they are."""
    robot = Robot.from_mapping(read_arm("ur10e").mapping)
    made = calibrated(robot, np.random.default_rng(1))
    poses = poses_of(np.array([[0.3, -1.0, 1.2, 0.4, 0.8, -0.5], [0.3, -1.0, 1.2, 0.4, 0.0, -0.5]]))
    exact = correct_joints(made.model, poses)
    assert exact.reached[0]
    found, given = brought_near(made.model, poses, exact)
    np.testing.assert_array_equal(found.q[exact.reached], exact.q[exact.reached])
    np.testing.assert_array_equal(given.q[~exact.reached], poses.q[~exact.reached])


def test_a_joint_never_moves_by_more_than_the_bound():
    """A place that cannot be taken at all is approached no further than the bound on the change of a joint."""
    made, poses, exact = at_zero("ur10e")
    far = exact.T_wanted.copy()
    far[:, :3, 3] *= 3.0
    bound = CorrectionSettings().small_change
    found, given = brought_near(made.model, poses, replace(exact, T_wanted=far, reached=np.array([False])))
    assert np.abs(found.q - poses.q).max() <= bound
    assert found.position_error[0] <= given.position_error[0]
