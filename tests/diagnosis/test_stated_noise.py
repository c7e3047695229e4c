"""The stated noise of a tracker does not decide what is found: the noise is estimated from the data, and a disagreement is reported."""

from __future__ import annotations

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from tests.tracked_targets import drawn_arm

TRUE = 1e-4  # m


def tracked(stated, gear=0.0, jitter=0.0, seed=1, targets=("ball",)):
    """Return 150 poses of an arm, with a gear error of joint 2 and joints that do not repeat [rad]."""
    rng = np.random.default_rng(seed)
    arm = drawn_arm(rng, targets)
    q = arm.poses(150, rng)
    q_true = q + rng.normal(0.0, jitter, q.shape) if jitter else q.copy()
    q_true[:, 1] += gear * np.sin(3 * q[:, 1])
    return arm.dataset(q, rng, noise=TRUE, stated={"noise": stated}, q_true=q_true)


@pytest.mark.parametrize("stated", [None, 1e-3, 1e-4, 1e-5])
def test_no_effect_is_named_whatever_noise_is_stated(stated):
    """If the stated noise is ten times too large, too small or missing, and nothing was injected, no effect and no variance component is named."""
    diagnosis = diagnose(tracked(stated), outer_folds=0)
    assert diagnosis.verdict == "no_effect"
    mapping = diagnosis.to_mapping()
    setup = [entry["what"] for entry in mapping["setup"]]
    assert setup == (["noise"] if stated == 1e-3 else [])
    if stated != 1e-5:
        assert mapping["noise"]["within_scan_mm"] == pytest.approx(0.1, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("stated", [None, 1e-3, 1e-4, 1e-5])
def test_a_gear_error_is_named_whatever_noise_is_stated(stated):
    """The gear error is named with its joint and order, and no variance component is identified."""
    diagnosis = diagnose(tracked(stated, gear=4e-4), outer_folds=0)
    (found,) = diagnosis.to_mapping()["effects"]
    assert (found["name"], found["target"]) == ("joint_harmonic", {"joint": 2, "order": 3})
    assert not diagnosis.noise


def test_a_jitter_is_distinguished_from_a_noise_that_is_stated_too_small():
    """A jitter of the joints is named, because its scatter grows with the distance of the tracked point from each axis, which that of the tracker
    does not.
    """
    diagnosis = diagnose(tracked(2e-5, jitter=4e-4), outer_folds=0)
    assert [c.name for c in diagnosis.noise] == ["pose_jitter"]


@pytest.mark.slow
@pytest.mark.parametrize("stated", [None, 2e-5])
def test_three_targets_measure_their_own_noise(stated):
    """If the stated noise is a fifth of the true one, three targets on the flange show their noise, and the gear error is found."""
    diagnosis = diagnose(tracked(stated, gear=4e-4, targets=("a", "b", "c")), outer_folds=0)
    assert [f.effect.name for f in diagnosis.findings] == ["joint_harmonic"] and not diagnosis.noise
    assert diagnosis.to_mapping()["noise"]["within_scan_mm"] == pytest.approx(0.1, rel=0.15)
