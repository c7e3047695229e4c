"""Errors from the moves between poses: angles logged before the arm had settled, and backlash on the side from which a joint came."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import diagnose
from scalar.report.noise_card import noise_clause
from tests.kinematics import joint_names
from tests.random_scene import make_scene

SHARE = 2e-3  # of the last step
PLAY = 3e-4  # rad, half of it


def read_as(error, seed, poses_per_plane=40):
    """Return a tracked arm whose encoders read ``q - error(q)`` at the true angles q, ``(N, 6)`` in order of acquisition."""
    dataset = make_scene(kind="tracker", seed=seed, poses_per_plane=poses_per_plane, noise=3e-5).dataset
    read = dataset.q - error(dataset.q)
    return replace(dataset, poses=dataset.poses.assign(**dict(zip(joint_names(6), read.T, strict=True))))


def lagging(q):
    """Return the error of every joint: a share of its step from the previous pose that is still to go."""
    return SHARE * np.diff(q, axis=0, prepend=q[:1])


FASTEST, ACCELERATION = 3.0, 15.0  # rad/s, rad/s^2, of every joint
SERVO = 0.05  # s: how late the joints follow what is commanded
WAITED = 0.15  # s: how long after the command's end the angles were logged


def still_to_go(step):
    """Return the share of a move that is still to go when the angles are logged, and which joint decides how long it takes.

    Joints start and arrive together, with a trapezoidal speed of which the joint that moves farthest reaches the limit; each follows the command
    with the time constant ``SERVO``.

    Args:
        step: ``(n,)`` [rad].
    """
    farthest = np.abs(step).max()
    ramp = min(FASTEST / ACCELERATION, np.sqrt(farthest / ACCELERATION))
    top = ACCELERATION * ramp
    duration = farthest / top + ramp
    t = np.linspace(0.0, duration, 2001)
    speed = np.minimum(np.minimum(ACCELERATION * t, top), ACCELERATION * (duration - t)) / farthest
    return np.trapezoid(speed * np.exp(-(duration + WAITED - t) / SERVO), t)


def arriving_together(q):
    """Return the error of every joint: what is still to go of a move in which all joints arrive at the same moment."""
    steps = np.diff(q, axis=0)
    shares = np.array([still_to_go(step) for step in steps])
    return np.vstack([np.zeros(q.shape[1]), shares[:, None] * steps])


def loose(joint):
    """Return the error of one joint: half of its backlash, on the side from which it came."""

    def error(q):
        dq = np.zeros_like(q)
        dq[:, joint - 1] = PLAY * np.sign(np.diff(q[:, joint - 1], prepend=q[0, joint - 1] - 1.0))
        return dq

    return error


@pytest.mark.parametrize("seed", [41, 42])
def test_angles_logged_too_early_are_named_and_nothing_else_is(seed):
    """If all joints still had a share of their step to go, lags are named with that share, and no scale error and no drift."""
    found = diagnose(read_as(lagging, seed)).findings
    assert {f.effect.name for f in found} == {"pose_lag"}
    joints = {f.effect.target["joint"] for f in found}
    assert {1, 2, 3} <= joints
    for f in found:
        assert f.effect.coefficients[0] == pytest.approx(SHARE, abs=0.25 * SHARE)
        assert "before" in f.effect.clause and f.effect.advice


@pytest.mark.parametrize("seed", [51, 52])
def test_the_joint_that_moves_farthest_decides_how_fast_the_others_move(seed):
    """If the joints arrive together and are logged before they have settled, their lags are named by their speeds, and nothing else is named."""
    dataset = read_as(arriving_together, seed)
    found = diagnose(dataset).findings
    assert {f.effect.name for f in found} == {"pose_lag"}
    assert {1, 2, 3} <= {f.effect.target["joint"] for f in found}
    true = arriving_together(dataset.q)
    for f in found:
        joint = f.effect.target["joint"] - 1
        told = (f.effect.joint_basis(dataset.robot, dataset.known_poses) @ f.effect.coefficients)[:, joint]
        assert "speed" in f.effect.clause
        assert np.std(told - true[:, joint]) < 0.3 * np.std(true[:, joint])


def varying_moments(q, seed):
    """Return by how much each pose is off at full speed ``(N, 1)``, 1 mrad in the mean, and the speeds of the joints as a share of it ``(N, 6)``."""
    steps = np.diff(q, axis=0, prepend=q[:1])
    farthest = np.maximum(np.abs(steps).max(axis=1, keepdims=True), 1e-9)
    return np.random.default_rng(seed).gamma(1.5, 1e-3 / 1.5, (len(q), 1)), steps / farthest


def read_at_varying_moments(seed):
    """Return a tracked arm of 120 poses whose angles were read at another moment of each move."""

    def error(q):
        off, speeds = varying_moments(q, seed)
        return off * speeds

    return read_as(error, seed)


@pytest.mark.parametrize("seed", [61, 62])
def test_poses_read_at_varying_moments_scatter_along_the_last_move(seed):
    """If each pose was read at another moment, lags are named by the speeds, and the scatter that remains lies along the last move."""
    dataset = read_at_varying_moments(seed)
    diagnosis = diagnose(dataset)
    assert {f.effect.name for f in diagnosis.findings} == {"pose_lag"}
    scatter = diagnosis.noise[0]
    assert scatter.name == "pose_jitter"
    assert scatter.along_move > 0.9 * scatter.std
    # What was drawn for the poses that were fitted: one or two in the tail of the distribution are set aside as gross errors.
    outliers = diagnosis.to_mapping()["outliers"]
    fitted = ~np.isin(dataset.pose_ids, [*outliers["poses"], *outliers["direction_unknown"]])
    off, speeds = (values[fitted] for values in varying_moments(dataset.q, seed))
    assert fitted.sum() >= dataset.n_poses - 3
    assert scatter.along_move == pytest.approx(np.std(off) * np.sqrt(np.mean(speeds**2)), rel=0.15)
    assert "along the last move" in noise_clause(diagnosis)
    entry = next(e for e in diagnosis.to_mapping()["effects"] if e["name"] == "pose_jitter")
    assert entry["coefficients"]["along_last_move_rad"]["value"] == scatter.along_move


DELAY = 2e-3  # s, of the measurement behind the angles


@pytest.mark.parametrize("seed", [71, 72])
def test_an_arm_that_is_measured_in_passing_has_a_delay(seed):
    """If the arm goes round the corner at each pose and is measured 2 ms after its angles were read, lags are named with that delay.

    Where an arm goes round a corner between two straight moves, its velocity is the mean of theirs; it starts and ends at rest.
    """
    dataset = make_scene(kind="tracker", seed=seed, poses_per_plane=60, noise=3e-5).dataset
    time = np.cumsum(np.random.default_rng(seed).uniform(3.0, 6.0, dataset.n_poses))
    of_moves = np.diff(dataset.q, axis=0) / np.diff(time)[:, None]
    velocity = np.zeros_like(dataset.q)
    velocity[1:-1] = 0.5 * (of_moves[1:] + of_moves[:-1])
    columns = dict(zip(joint_names(6), (dataset.q - DELAY * velocity).T, strict=True))
    table = dataset.poses.assign(**columns, time=time, order=np.arange(dataset.n_poses))
    found = diagnose(replace(dataset, poses=table)).findings
    assert {f.effect.name for f in found} == {"pose_lag"}
    assert {1, 2, 3} <= {f.effect.target["joint"] for f in found}
    for f in found:
        assert "passes" in f.effect.clause
        assert f.effect.coefficients[-1] == pytest.approx(DELAY, rel=0.4)


def test_backlash_is_named_by_the_moves():
    """If no direction of approach is recorded, it follows from the order of the poses, and the backlash is named."""
    found = diagnose(read_as(loose(3), 43)).findings
    assert [(f.effect.name, f.effect.target) for f in found] == [("joint_backlash", {"joint": 3})]
    assert found[0].effect.by == "moves"
    assert found[0].effect.coefficients[0] == pytest.approx(PLAY, rel=0.2)


@pytest.mark.parametrize("seed", [44, 45, 46])
def test_moves_that_leave_nothing_are_no_finding(seed):
    """With poses in a known order and nothing injected, nothing is named."""
    assert not diagnose(read_as(np.zeros_like, seed)).findings


def test_predictions_are_for_an_arm_at_rest():
    """Predictions without an order of poses contain no lag; with an order, the lag acts from pose to pose."""
    diagnosis = diagnose(read_as(lagging, 41))
    calibration = diagnosis.calibration_after
    assert calibration.model.effects
    rigid = replace(calibration, model=replace(calibration.model, effects=()))
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 6))
    np.testing.assert_allclose(calibration.predict(q), rigid.predict(q), rtol=0, atol=1e-14)
    import pandas as pd

    ordered = pd.DataFrame(q, columns=joint_names(6)).assign(order=np.arange(20.0))
    assert np.abs(calibration.predict(ordered) - rigid.predict(ordered)).max() > 1e-4
