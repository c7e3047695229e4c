"""What moves leave: angles logged before the arm had settled, and play on the side from which a joint came."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import diagnose
from tests.kinematics import joint_names
from tests.random_scene import make_scene

SHARE = 2e-3  # of the last step
PLAY = 3e-4  # rad, half of it


def read_as(error, seed, poses_per_plane=40):
    """Return a tracked arm whose encoders read ``q - error(q)`` where it stood at q, ``(N, 6)`` in order of acquisition."""
    dataset = make_scene(kind="tracker", seed=seed, poses_per_plane=poses_per_plane, noise=3e-5).dataset
    read = dataset.q - error(dataset.q)
    return replace(dataset, poses=dataset.poses.assign(**dict(zip(joint_names(6), read.T, strict=True))))


def lagging(q):
    """Return what is still to go of the way from the pose before, in every joint."""
    return SHARE * np.diff(q, axis=0, prepend=q[:1])


def loose(joint):
    """Return half of one joint's play, on the side from which it came."""

    def error(q):
        dq = np.zeros_like(q)
        dq[:, joint - 1] = PLAY * np.sign(np.diff(q[:, joint - 1], prepend=q[0, joint - 1] - 1.0))
        return dq

    return error


@pytest.mark.parametrize("seed", [41, 42])
def test_angles_logged_too_early_are_named_and_nothing_else_is(seed):
    """All joints still had a share of their way to go: lags are named, no scale error and no drift; their share comes back."""
    found = diagnose(read_as(lagging, seed)).findings
    assert {f.effect.name for f in found} == {"pose_lag"}
    joints = {f.effect.target["joint"] for f in found}
    assert {1, 2, 3} <= joints
    for f in found:
        assert f.effect.coefficients[0] == pytest.approx(SHARE, abs=0.25 * SHARE)
        assert "before" in f.effect.clause and f.effect.advice


def test_play_is_named_by_the_way_that_a_joint_came():
    """Where no direction of approach is recorded, the order of the poses tells it."""
    found = diagnose(read_as(loose(3), 43)).findings
    assert [(f.effect.name, f.effect.target) for f in found] == [("joint_backlash", {"joint": 3})]
    assert found[0].effect.by == "moves"
    assert found[0].effect.coefficients[0] == pytest.approx(PLAY, rel=0.2)


@pytest.mark.parametrize("seed", [44, 45, 46])
def test_moves_that_leave_nothing_are_no_finding(seed):
    """Poses in a known order, nothing wrong: nothing is named."""
    assert not diagnose(read_as(np.zeros_like, seed)).findings


def test_predictions_are_for_an_arm_at_rest():
    """Without an order a lag does not act; with one it acts from pose to pose."""
    diagnosis = diagnose(read_as(lagging, 41))
    calibration = diagnosis.calibration_after
    assert calibration.model.effects
    rigid = replace(calibration, model=replace(calibration.model, effects=()))
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 6))
    np.testing.assert_array_equal(calibration.predict(q), rigid.predict(q))
    import pandas as pd

    ordered = pd.DataFrame(q, columns=joint_names(6)).assign(order=np.arange(20.0))
    assert np.abs(calibration.predict(ordered) - rigid.predict(ordered)).max() > 1e-4
