"""Arms with fewer than six joints take the wanted places, and the orientations that they can."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.correction import correct_frames, correct_joints, postures_for
from scalar.geometry.se3 import exp_so3
from tests.calibrated_arms import calibrated
from tests.estimation.test_correction import first_joints
from tests.turning import turning


@pytest.mark.parametrize("n", [3, 4, 5])
def test_fewer_joints_meet_the_place(n):
    """An arm of three to five joints meets the place to 1e-6 m, whatever that leaves of the orientation."""
    rng = np.random.default_rng(n)
    robot = first_joints(n)
    calibration = calibrated(robot, rng, (JointHarmonic(2, (1,), coefficients=np.array([3e-4, 0.0])),))
    q = rng.uniform(-1.0, 1.0, (100, n))
    q[:, 2] = rng.uniform(0.6, 1.6, 100)  # a bent elbow: stretched, the arm reaches no further
    found = correct_joints(calibration.model, Poses.from_arrays(q, {}, turning(n)))
    assert found.reached.mean() > 0.95
    off = np.linalg.norm((calibration.predict(found.q) - found.T_wanted)[:, :3, 3], axis=1)
    assert off[found.reached].max() < 1e-6


@pytest.mark.parametrize("n", [4, 5])
def test_frames_that_an_arm_of_few_joints_can_take_are_found_whole(n):
    """Frames that the arm takes somewhere are found with their orientation, without joint angles to start from."""
    rng = np.random.default_rng(10 + n)
    model = calibrated(first_joints(n), rng).model
    q = rng.uniform(-1.0, 1.0, (20, n))
    q[:, 2] = rng.uniform(0.6, 1.6, 20)
    wanted = model.robot.flange(q) @ model.T_flange_sensor
    start, there = postures_for(model, wanted)
    found = correct_frames(model, Poses.from_arrays(start, {}, turning(n)), wanted)
    assert there.all() and found.reached.all()
    assert found.position_error.max() < 1e-6 and found.orientation_error.max() < 1e-3


@pytest.mark.parametrize(("turn", "taken"), [(0.01, True), (1.0, False), (2.5, False), (np.pi, False)])
def test_the_error_of_the_orientation_is_the_angle(turn, taken):
    """A tool that is upside down is half a turn off, and not in place because the sine of half a turn is zero."""
    rng = np.random.default_rng(4)
    model = calibrated(first_joints(4), rng).model
    q = np.array([[0.2, -0.3, 1.1, 0.4]])
    here = model.robot.flange(q) @ model.T_flange_sensor
    wanted = here.copy()
    axis = here[0, :3, :3] @ np.array([0.0, 1.0, 0.0])
    wanted[0, :3, :3] = exp_so3(axis * turn) @ here[0, :3, :3]
    found = correct_frames(model, Poses.from_arrays(q, {}, turning(4)), wanted)
    R = wanted[0, :3, :3] @ (model.robot.flange(found.q) @ model.T_flange_sensor)[0, :3, :3].T
    angle = np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0))
    assert abs(found.orientation_error[0] - angle) < 1e-4
    assert found.reached[0] == taken
