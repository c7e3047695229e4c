"""The mechanics of the tracked arm with its causes, contacts in their order, and the errors that are judged."""

import numpy as np
import pytest
from study.common import kinematics
from study.tracked_trials.flawed_arm import Acquisition, FlawedArm
from study.tracked_trials.measure import FIRST, contacts
from study.tracked_trials.run import unseen_error
from study.tracked_trials.tracked_arm import TrackedArm

from tests.study.tracked_trials.causes import cause
from tests.tracked_targets import drawn_arm


@pytest.fixture(scope="module")
def arm():
    """Return a true arm."""
    return drawn_arm(np.random.default_rng(1), (FIRST,))


def acquisition(n, rng, jitter=0.0):
    """Return an acquisition of n poses of an arm with six joints."""
    time = np.arange(n) * 30.0
    approach = np.sign(rng.normal(size=(n, 6)))
    return Acquisition(time, max(time[-1], 1.0) / 3, approach, jitter * rng.normal(size=(n, 6)))


def test_an_arm_without_causes_is_rigid(arm):
    """An arm without causes is rigid; so is, at rest, an arm whose causes act only during an acquisition."""
    rng = np.random.default_rng(2)
    q = arm.poses(20, rng)
    rigid = kinematics.chain(arm.geometry, q) @ arm.T_n_flange
    moving = [cause("joint_backlash", {"joint": 2}), cause("pose_lag", {"joint": 1}), cause("thermal_drift")]
    np.testing.assert_array_equal(FlawedArm(arm, []).flange(q), rigid)
    np.testing.assert_array_equal(FlawedArm(arm, moving).flange(q), rigid)
    assert np.abs(FlawedArm(arm, moving).flange(q, acquisition(20, rng)) - rigid).max() > 1e-5


def test_a_loaded_arm_gives_way_downwards(arm):
    """With compliant joints or a compliant base the potential energy falls, in proportion to the compliance."""
    q = arm.poses(50, np.random.default_rng(3))
    for name, target in (("joint_compliance", {"joints": [2, 3]}), ("base_compliance", {})):
        rigid = FlawedArm(arm, []).flange(q)[:, 2, 3]
        once = FlawedArm(arm, [cause(name, target)]).flange(q)[:, 2, 3] - rigid
        twice = FlawedArm(arm, [cause(name, target) | {"size": 2e-5}]).flange(q)[:, 2, 3] - rigid
        assert once.mean() < -1e-4
        np.testing.assert_allclose(twice, 2 * once, atol=0.02 * np.abs(once).max())


def test_torques_are_weights_times_levers(arm):
    """Joint 1 is upright and bears no torque, so turning it lifts nothing, and the moment about the base turns with it."""
    q = arm.poses(10, np.random.default_rng(4))
    upright = TrackedArm(
        arm.name, arm.geometry * np.array([1, 1, 1, 1, 0])[:, None], arm.targets, arm.T_tracker_base
    )
    upright.geometry[:2, 0] = 0.0  # the first joint stands in the middle of the base
    turned = q + np.eye(6)[0] * 0.7
    energy, moment = FlawedArm(upright, []).moments(q)
    energy_turned, moment_turned = FlawedArm(upright, []).moments(turned)
    np.testing.assert_allclose(energy_turned, energy)
    turn = kinematics.rotation(2, 0.7)[:2, :2]
    np.testing.assert_allclose(moment_turned, moment @ turn.T)


def test_contacts_lag_behind_the_pose_that_is_kept_before_them(arm):
    """Poses that reach nothing are left out before the steps between poses are made: the dataset's own angles bring the tip to its planes."""
    rng = np.random.default_rng(5)
    flawed = FlawedArm(arm, [cause("pose_lag", {"joint": 2}), cause("joint_backlash", {"joint": 3})])
    q, during = arm.poses(40, rng), acquisition(40, rng, jitter=2e-5)
    places = arm.at(q, FIRST)[:, :3, 3]
    normals = np.tile([0.0, 0.0, 1.0], (40, 1))
    distances = np.full(40, np.quantile(places[:, 2], 0.4))
    distances[[3, 17, 18]] = 9.0  # out of reach
    solved, kept = contacts(flawed, q, during, normals, distances)
    assert not kept[[3, 17, 18]].any() and 20 < len(solved) == kept.sum() < 40
    heights = (flawed.flange(solved, during.of(kept)) @ arm.targets[FIRST])[:, 2, 3]
    np.testing.assert_allclose(heights, distances[kept], atol=2e-9)


def test_an_error_is_taken_after_base_and_scale_are_placed():
    """A moved base adds no error, nor does a scale if it is free."""
    rng = np.random.default_rng(6)
    truth = np.stack([kinematics.random_transform(rng, 1.0, 1.0) for _ in range(30)])
    moved = kinematics.random_transform(rng, 2.0, 1.5) @ truth
    assert unseen_error(moved, truth) < 1e-12
    moved[:, :3, 3] *= 1.001
    assert unseen_error(moved, truth) > 5e-4
    assert unseen_error(moved, truth, scaled=True) < 1e-12
