"""Unit gravity torques: they span the statics of every arm with these axes, whatever its masses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar.data.poses import Poses
from scalar.effects.gravity import torque_basis, torque_of, typical_masses, typical_torque, unit_moments
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.geometry.robot import Robot
from tests import kinematics
from tests.effects.injected import gravity_torques
from tests.random_scene import make_scene

ROBOTS = ("vs060", "ur10e", "puma560", "panda")


def arm(name, seed):
    """Return an arm of the maker's geometry, its truth for other kinematics, and poses ``(40, n)``."""
    truth = make_scene(name, kind="tracker", seed=0, poses_per_plane=2).truth
    robot = Robot(
        name, truth.geometry, truth.limits, truth.T_base_0, truth.T_n_flange, np.array([0.0, 0.0, -9.81])
    )
    return robot, truth, np.random.default_rng(seed).uniform(-3.0, 3.0, (40, robot.n_joints))


@settings(max_examples=12)
@given(name=st.sampled_from(ROBOTS), seed=st.integers(0, 10**6))
def test_moments_span_the_statics_of_any_masses(name, seed):
    """For links of any mass anywhere, the torque on each joint is a combination of unit torques of the frames beyond it.

    The torque is minus the gradient of the potential energy.
    """
    robot, truth, q = arm(name, seed)
    rng = np.random.default_rng(seed)
    n = robot.n_joints
    masses, centres = rng.uniform(0.0, 20.0, n), rng.uniform(-0.5, 0.5, (n, 3))
    torque = gravity_torques(truth, q, masses, centres)
    for joint in range(1, n + 1):
        basis = np.hstack([torque_basis(robot, q, joint, frame) for frame in range(joint, n + 1)])
        rest = torque[:, joint - 1] - basis @ np.linalg.lstsq(basis, torque[:, joint - 1], rcond=None)[0]
        assert np.abs(rest).max() < 1e-6 * max(np.abs(torque).max(), 1.0), f"joint {joint}"


def test_moments_span_the_statics_of_an_arm_whose_third_joint_slides():
    """What a slide carries loads the joints before it in proportion to its travel, whatever the masses."""
    rng = np.random.default_rng(0)
    n, slide = 5, 2
    geometry = rng.uniform(-0.6, 0.6, (5, n)) * np.array([1, 1, 1, 1, 0])[:, None]
    limits = np.tile([-3.0, 3.0], (n, 1))
    limits[slide] = [-0.2, 0.9]
    gravity = np.array([1.0, 2.0, -9.0])
    robot = Robot("sliding", geometry, limits, np.eye(4), np.eye(4), gravity, prismatic=(slide,))
    q = rng.uniform(*limits.T, (400, n))
    masses, centres = rng.uniform(1.0, 5.0, n), rng.uniform(-0.3, 0.3, (n, 3))
    d = np.where(np.arange(n) == slide, geometry[2] + q, geometry[2])
    theta = np.where(np.arange(n) == slide, geometry[3], geometry[3] + q)
    T, frames = np.tile(np.eye(4), (len(q), 1, 1)), []
    for i in range(n):
        T = T @ kinematics.rotation(0, geometry[1, i]) @ kinematics.translation(0, geometry[0, i])
        T = T @ kinematics.rotation(2, theta[:, i]) @ kinematics.translation(2, d[:, i])
        frames.append(T)
    for joint in (j for j in range(n) if j != slide):
        places = [frames[f][:, :3, 3] + frames[f][:, :3, :3] @ centres[f] for f in range(joint, n)]
        torque = sum(
            np.einsum("nx,nx->n", np.cross(p - frames[joint][:, :3, 3], m * gravity), frames[joint][:, :3, 2])
            for p, m in zip(places, masses[joint:], strict=True)
        )
        basis = np.hstack([torque_basis(robot, q, joint + 1, f + 1) for f in range(joint, n)])
        rest = torque - basis @ np.linalg.lstsq(basis, torque, rcond=None)[0]
        assert np.abs(rest).max() < 1e-9 * np.abs(torque).max(), f"joint {joint + 1}"


@pytest.mark.parametrize("name", ROBOTS)
def test_one_set_of_moments_serves_all_joints(name):
    """The first moments that explain one joint's torque explain those of all joints, if all are equally soft, since they are physical."""
    robot, truth, q = arm(name, 3)
    rng = np.random.default_rng(4)
    n = robot.n_joints
    torque = gravity_torques(truth, q, rng.uniform(1.0, 9.0, n), rng.uniform(-0.2, 0.2, (n, 3)))
    moments, axes = unit_moments(robot, q)
    A = np.einsum("nfax,njx->njfa", moments, axes)
    for joint in range(n):
        A[:, joint, :joint] = 0.0  # what is inside a joint does not load it
    A = A.reshape(-1, 2 * n)
    rest = torque.ravel() - A @ np.linalg.lstsq(A, torque.ravel(), rcond=None)[0]
    assert np.abs(rest).max() < 1e-6 * np.abs(torque).max()


@pytest.mark.parametrize("name", ROBOTS)
def test_a_compliance_moves_its_own_joint_alone(name):
    """The compliance of joint 2 under the weight of frame 3 has an angle error of joint 2, and of no other joint."""
    robot, _, q = arm(name, 5)
    poses = Poses(q, np.arange(len(q), dtype=float), {})
    B = JointCompliance(((2, 3),)).joint_basis(robot, poses)
    assert np.abs(B[:, 1]).max() > 0.1
    assert not np.delete(B, 1, axis=1).any()


def test_the_typical_torque_has_the_sign_of_gravity():
    """The torque on the shoulder of an arm that is stretched out level turns it downwards, on both sides."""
    robot, truth, _ = arm("vs060", 0)
    n = robot.n_joints
    rng = np.random.default_rng(1)
    q = rng.uniform(-2.0, 2.0, (50, n))
    torque = typical_torque(robot, q, 2)
    h = 1e-4
    ahead = q.copy()
    ahead[:, 1] += h
    masses = np.zeros(n)
    masses[2:] = 1.0
    exact = gravity_torques(truth, q, masses, np.zeros((n, 3)))[:, 1]
    heavy = np.abs(exact) > 0.5 * np.abs(exact).max()
    assert np.all(np.sign(torque[heavy]) == np.sign(exact[heavy]))


@pytest.mark.parametrize("name", ROBOTS)
def test_typical_masses_give_the_typical_torque_at_other_poses(name):
    """One factor, which is the size of the masses, relates the two torques at all poses, for any joint that gravity loads."""
    robot, _, q = arm(name, 7)
    for joint in range(2, robot.n_joints):
        masses = typical_masses(robot, q[:20], joint)
        ours, theirs = torque_of(robot, q[20:], joint, masses), typical_torque(robot, q[20:], joint)
        if np.abs(theirs).max() < 1e-6:
            continue
        factor = float(ours @ theirs / (theirs @ theirs))
        assert factor > 0
        np.testing.assert_allclose(ours, factor * theirs, atol=1e-9 * np.abs(ours).max() + 1e-12)


def test_the_side_of_a_backlash_has_variations_by_the_masses():
    """A backlash whose side the weight decides has variations, each of which differs at some poses and agrees at most."""
    robot, _, q = arm("vs060", 9)
    poses = Poses(q, np.arange(len(q), dtype=float), {})
    masses = tuple(float(m) for m in typical_masses(robot, q, 2))
    effect = JointBacklash(2, "torque", masses)
    side = effect.joint_basis(robot, poses)[:, 1, 0]
    shares = [np.mean(e.joint_basis(robot, poses)[:, 1, 0] == side) for e in effect.variations(1.0)]
    assert len(shares) == 1 + 2 * len(masses)
    assert max(shares) == 1.0
    assert 0.5 < min(shares) < 1.0


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_a_play_is_against_its_load_if_the_joint_rests_on_the_upper_side(name, turned):
    """The sign of the coefficient decides, together with that of the masses; a side told by the approach has no load."""
    robot, _, q = arm(name, 9)
    poses = Poses(q, np.arange(len(q), dtype=float), {})
    masses = tuple(turned * float(m) for m in typical_masses(robot, q, 2))
    for size in (3e-4, -3e-4):
        effect = JointBacklash(2, "torque", masses).with_coefficients([size])
        assert effect.against_its_load(robot, poses) == (turned * size < 0)
        assert not JointBacklash(2, "approach").with_coefficients([size]).against_its_load(robot, poses)
