"""Campaigns of the real-arm trials: what a tracker measures is where the arm stands by a second computation, with each effect by its own formula."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from study.common import kinematics
from study.common.kinematics import joint_names
from study.real_arm_trials.campaign import config_of
from study.real_arm_trials.design import load_real_arm
from study.real_arm_trials.tracked import spans, tracked_campaign, walk

from scalar.simulation.plan import workcell_of
from scalar.simulation.records import LOADS

ROOT = Path(__file__).parents[3]
LAG, SCALE, PLAY = 2e-3, 4e-4, 1e-4


@pytest.fixture(scope="module")
def quiet():
    """Return a set of a tracker without noise and causes."""
    trial = load_real_arm(ROOT / "configs/real_arm_trials.yaml").trial("tracker", 0)
    return replace(
        trial, robot="ur10e", poses=60, unseen=20, causes=(), noise_m=0.0, states_noise=False, repeatability_rad=0.0,
        record=(), sessions=1, stops=0,
    )  # fmt: skip


def entry(effect, target=None, size=1.0, **more):
    """Return an entry of ``injected``."""
    return {"effect": effect, "target": target or {}, "size": size, **more}


def places(trial, q):
    """Return where the true arm's target is at joint angles ``(N, n)`` [rad] in its base frame ``(N, 3)`` [m], by elementary matrices."""
    arm = workcell_of(config_of(replace(trial, causes=()), ROOT)).arm
    geometry = np.array([arm.a, arm.alpha, arm.d, arm.theta, arm.beta])
    return (kinematics.chain(geometry, q) @ arm.T_n_flange @ arm.T_flange_sensor)[:, :3, 3]


def gap(found, expected):
    """Return the largest distance [m] of places ``(N, 3)`` from others after the best rigid motion (Kabsch)."""
    a, b = found - found.mean(0), expected - expected.mean(0)
    U, _, Vt = np.linalg.svd(b.T @ a)
    return np.abs(a - b @ (U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt)).max()


def standing(trial, error):
    """Return how far the measured points are from those of an arm at q + error(q) [m]."""
    dataset = tracked_campaign(trial, ROOT).dataset
    return gap(dataset.points, places(trial, dataset.q + error(dataset.q)))


def of_joint(joint, values):
    """Return errors ``(N, 6)`` [rad] of one joint."""
    return np.asarray(values)[:, None] * np.eye(6)[joint - 1]


def test_an_arm_without_causes_stands_where_its_encoders_say(quiet):
    """Without causes the tracker measures the rigid arm, and unseen poses are those of the same arm."""
    assert standing(quiet, np.zeros_like) < 1e-9
    campaign = tracked_campaign(quiet, ROOT)
    q = campaign.unseen[joint_names(6)].to_numpy()
    assert gap(campaign.truth[:, :3, 3], places(quiet, q)) < 1e-9
    assert not campaign.injected and "order" not in campaign.unseen


def test_a_lag_begins_anew_in_each_session(quiet):
    """Joint 2 rests where the share of its step that was still to go leads; at the first pose of each of two sessions it rests where it is read."""
    trial = replace(quiet, sessions=2, causes=(entry("pose_lag", {"joint": 2}, LAG),))
    dataset = tracked_campaign(trial, ROOT).dataset
    assert list(dataset.poses["session"]) == 30 * ["day 1"] + 30 * ["day 2"]
    rests = dataset.q.copy()
    for k in range(1, 60):
        if k != 30:
            rests[k, 1] = (dataset.q[k, 1] - LAG * rests[k - 1, 1]) / (1 - LAG)
    for day in (slice(0, 30), slice(30, 60)):  # the tracker has another place in each
        assert gap(dataset.points[day], places(trial, rests[day])) < 1e-9
        assert gap(dataset.points[day], places(trial, dataset.q[day])) > 1e-4
    campaign = tracked_campaign(trial, ROOT)
    at_rest = places(trial, campaign.unseen[joint_names(6)].to_numpy())
    assert gap(campaign.truth[:, :3, 3], at_rest) < 1e-9


def test_play_is_taken_up_by_the_last_move(quiet):
    """A joint that moved up rests above its reading by half of the play, and one that moved down below."""
    trial = replace(quiet, causes=(entry("joint_backlash", {"joint": 3}, PLAY, by_moves=True),))
    sides = lambda q: of_joint(3, PLAY * np.r_[1.0, np.sign(np.diff(q[:, 2]))])  # noqa: E731
    assert standing(trial, sides) < 1e-9 < 1e-5 < standing(trial, np.zeros_like)


def test_a_payload_bends_joints_by_its_lever(quiet):
    """Joint 2 yields to the payload's weight: the height of its centre of mass falls with the angle by the error over compliance and weight."""
    size = 6e-6
    trial = replace(
        quiet, record=("payload",), causes=(entry("payload_deflection", {"joints": [2]}, size),), seed=3
    )
    dataset = tracked_campaign(trial, ROOT).dataset
    poses = dataset.poses
    assert set(poses["payload"]) == set(LOADS)
    workcell = workcell_of(config_of(replace(trial, causes=()), ROOT))
    arm, centre = workcell.arm, np.r_[poses[["payload_x", "payload_y", "payload_z"]].to_numpy()[0], 1.0]
    geometry = np.array([arm.a, arm.alpha, arm.d, arm.theta, arm.beta])
    height = lambda q: (kinematics.chain(geometry, q) @ arm.T_n_flange @ centre)[:, 2]  # noqa: E731
    step = 1e-5 * np.eye(6)[1]
    slope = (height(dataset.q + step) - height(dataset.q - step)) / 2e-5
    error = of_joint(2, -size * 9.81 * poses["payload"].to_numpy() * slope)
    assert np.abs(error).max() > 1e-4
    assert gap(dataset.points, places(trial, dataset.q + error)) < 1e-8


def test_a_tracker_drifts_in_the_course_of_the_campaign(quiet):
    """The motion between arm and tracker is one line in time: no rigid motion places all poses, and one places the poses of a short while."""
    trial = replace(quiet, record=("time",), causes=(entry("target_drift", size=1e-3),))
    dataset = tracked_campaign(trial, ROOT).dataset
    expected = places(trial, dataset.q)
    assert gap(dataset.points, expected) > 1e-4
    assert gap(dataset.points[50:55], expected[50:55]) < 0.2 * gap(dataset.points, expected)


def test_an_axis_carries_the_arm_along_a_line(quiet):
    """Joint 1 is a travel in metres with a scale error of its own; the joints of the arm follow, in the dataset and in the truth."""
    causes = (entry("joint_scale", {"joint": 1}, SCALE, on_rail=True), entry("pose_lag", {"joint": 2}, LAG))
    trial = replace(quiet, instrument="rail", causes=causes)
    campaign = tracked_campaign(trial, ROOT)
    dataset = campaign.dataset
    assert dataset.robot.prismatic == (0,) and dataset.robot.n_joints == 7
    assert [(e["name"], e["target"]) for e in campaign.injected] == [
        ("joint_scale", {"joint": 1}),
        ("pose_lag", {"joint": 3}),
    ]
    alone = tracked_campaign(replace(trial, causes=causes[:1]), ROOT).dataset
    free = tracked_campaign(replace(trial, causes=()), ROOT).dataset
    moved = np.linalg.norm(alone.points - free.points, axis=1)
    np.testing.assert_allclose(moved, SCALE * np.abs(free.q[:, 0]), atol=1e-12)


def test_the_walk_has_short_and_long_moves_within_its_bounds(quiet):
    """Moves spread over two decades, and every pose is within the bounds; an axis moves in metres."""
    workcell = workcell_of(config_of(quiet, ROOT))
    low, high = spans(workcell, True)
    q = walk(low, high, True, 400, np.random.default_rng(1))
    assert (q >= low).all() and (q <= high).all()
    moves = np.abs(np.diff(q, axis=0))
    for joint, (short, long) in ((0, (0.05, 0.4)), (3, (0.08, 0.8))):
        assert 0.1 < (moves[:, joint] < short).mean() < 0.6 and (moves[:, joint] > long).mean() > 0.1
