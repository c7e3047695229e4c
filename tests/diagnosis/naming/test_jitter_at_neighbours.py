"""Neighbouring poses tell a jitter from an error that varies smoothly with the joint angles, if they are near enough."""

import numpy as np
import pytest

from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.naming import limits_of_noise
from scalar.diagnosis.naming.jitter_at_neighbours import excludes_smooth_error, share_by_angles
from scalar.diagnosis.naming.jitter_at_returns import NO_RETURNS
from scalar.diagnosis.naming.limits_of_noise import MAY_BE_A_REST, MAY_BE_SMOOTH, limit_of_noise
from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from tests.diagnosis.scattered import ROWS, scattered

JOINTS, STD = 4, 2e-4  # number of joints, and the standard deviation of the error of each [rad]


@pytest.fixture
def campaign(monkeypatch):
    """Return a function that makes a stand-in for a state, and its component.

    Its arguments: the number of poses, the share of the error's variance that varies smoothly, as waves of up to one period a turn do, and the seed.
    """

    def make(poses, smooth, seed):
        rng = np.random.default_rng(seed)
        q = rng.uniform(-2.5, 2.5, (poses, JOINTS))
        waves = (
            rng.normal(size=(300, JOINTS)) / 1.5
        )  # of a Gaussian process whose correlation falls over 1.5 rad
        phases, sizes = rng.uniform(0, 2 * np.pi, 300), rng.normal(size=(300, JOINTS))
        of_pose = np.cos(q @ waves.T + phases) @ sizes * np.sqrt(2 / 300)
        e = np.sqrt(smooth) * of_pose + np.sqrt(1 - smooth) * rng.normal(size=(poses, JOINTS))
        return scattered(monkeypatch, rng, "pose_jitter", STD * e, 2e4, STD, q=q)

    return make


def test_of_a_random_error_nothing_varies_smoothly(campaign):
    """Over sixty seeds the estimate has mean zero and the stated standard error."""
    ratios = []
    for seed in range(60):
        share, error = share_by_angles(*campaign(80, 0.0, seed))
        ratios.append(share / error)
    assert abs(np.mean(ratios)) < 3 / np.sqrt(60)
    assert 0.7 < np.std(ratios) < 1.3


def test_of_a_smooth_error_all_does(campaign):
    """Of an error whose correlation falls as assumed, the mean estimate over thirty seeds is all of it, to a quarter."""
    shares = [share_by_angles(*campaign(150, 1.0, seed))[0] for seed in range(30)]
    assert np.mean(shares) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(
    ("poses", "smooth", "excluded"),
    [(300, 0.0, True), (300, 1.0, False), (8, 0.0, False)],
    ids=["random", "smooth", "few poses"],
)
def test_a_smooth_error_is_excluded_only_if_many_poses_show_that_there_is_none(
    campaign, poses, smooth, excluded
):
    """Many poses exclude a smooth error where the error is random, do not where it is smooth, and few poses leave it open."""
    answers = [excludes_smooth_error(*campaign(poses, smooth, seed)) for seed in range(10)]
    assert sum(answers) >= 9 if excluded else sum(answers) <= 1


def test_poses_of_which_none_is_near_another_exclude_nothing(campaign):
    """Where the joint angles are so far apart that no pair of poses tells anything, the standard error is infinite."""
    state, component = campaign(20, 0.0, 3)
    state.dataset.q = 1e3 * np.arange(20.0)[:, None] * np.ones((1, JOINTS))
    assert share_by_angles(state, component)[1] == np.inf
    assert not excludes_smooth_error(state, component)


@pytest.mark.parametrize(
    ("excluded", "beside", "returns", "expected"),
    [
        (True, False, NOT_SURE, (NOT_SURE, NO_RETURNS)),
        (False, False, NOT_SURE, (ONE_OF_TWO, MAY_BE_SMOOTH)),
        (True, True, NOT_SURE, (ONE_OF_TWO, MAY_BE_A_REST)),
        (False, True, 1.0, (1.0, NO_RETURNS)),
    ],
    ids=["random", "may be smooth", "beside structure", "returns show it"],
)
def test_a_jitter_has_no_name_unless_returns_or_neighbours_bear_it_out(
    monkeypatch, excluded, beside, returns, expected
):
    """Without returns, a jitter is as likely as not where neighbours leave a smooth error open, or unmodelled structure was found as well."""
    monkeypatch.setattr(limits_of_noise, "most_confidence_at_returns", lambda *_: returns)
    monkeypatch.setattr(limits_of_noise, "most_confidence_in_time", lambda *_: 1.0)
    monkeypatch.setattr(limits_of_noise, "excludes_smooth_error", lambda *_: excluded)
    component = VarianceComponent("pose_jitter", STD, 1e-5, 50.0, 1e-9, np.eye(ROWS)[None])
    assert limit_of_noise(None, component, None, beside_structure=beside) == expected
