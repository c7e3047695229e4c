"""A jitter is sure only where returns to the same poses bear it out: an error that belongs to the pose is there again, and a random one is not."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.naming import limits_of_noise
from scalar.diagnosis.naming.jitter_at_returns import (
    NO_RETURNS,
    most_confidence_at_returns,
    share_in_common,
)
from scalar.diagnosis.naming.limits_of_noise import limit_of_noise
from scalar.diagnosis.naming.most_confidence import NOT_SURE

ROWS, STD = 2, 2e-4  # rows of a pose, and the jitter in each joint [rad]


def campaign(poses, visits, of_pose, seed, apart=0.0, still=False):
    """Return a stand-in for a state, and its component, from random residuals.

    Args:
        poses, visits: Number of poses, and how often each is measured.
        of_pose: Share of the component's variance that belongs to the pose, and is the same at every visit.
        seed: Of the random numbers.
        apart: How far apart the joint angles of two visits are [rad].
        still: Whether the arm stays at a pose for all its visits, so that these are readings of one standstill.
    """
    rng = np.random.default_rng(seed)
    pose = np.repeat(np.arange(poses), visits) if still else np.tile(np.arange(poses), visits)
    N = poses * visits
    q = rng.uniform(-2.0, 2.0, (poses, 6))[pose] + apart * np.arange(N)[:, None]
    D = (
        rng.normal(size=(poses, ROWS, 6))[pose] * 2e4
    )  # derivatives of whitened rows by the joint angles [1/rad]
    errors = np.sqrt(of_pose) * rng.normal(size=(poses, 6))[pose] + np.sqrt(1.0 - of_pose) * rng.normal(
        size=(N, 6)
    )
    z = rng.normal(size=(N, ROWS)) + np.einsum("nrj,nj->nr", D, STD * errors)
    covariance = np.eye(ROWS) + STD**2 * D @ np.swapaxes(D, 1, 2)
    state = SimpleNamespace(
        dataset=SimpleNamespace(n_poses=N, q=q, known_poses=SimpleNamespace(order=np.arange(float(N)))),
        residuals=SimpleNamespace(
            measurement=SimpleNamespace(rows_per_pose=ROWS, target_index=np.zeros(N, dtype=int))
        ),
        background_within_scans=lambda: SimpleNamespace(residual=z.ravel()),
    )
    return state, VarianceComponent("pose_jitter", STD, 1e-5, 50.0, 1e-9, covariance)


@pytest.mark.parametrize("of_pose", [0.0, 0.4, 1.0])
def test_the_share_is_that_which_belongs_to_the_pose(of_pose):
    """The estimate lies within three standard errors of the share with which the errors were drawn, for each of twenty seeds but one at most."""
    off = []
    for seed in range(20):
        share, error = share_in_common(*campaign(100, 2, of_pose, seed))
        off.append(abs(share - of_pose) / error)
    assert sorted(off)[-2] < 3.0


@pytest.mark.parametrize(
    ("settings", "sure"),
    [
        ({"of_pose": 0.0}, True),
        ({"of_pose": 1.0}, False),
        ({"of_pose": 0.0, "poses": 4}, False),
        ({"of_pose": 0.0, "visits": 1, "poses": 200}, False),
        ({"of_pose": 0.0, "apart": 1e-3}, False),
        ({"of_pose": 0.0, "still": True}, False),
    ],
    ids=["random", "of the pose", "few returns", "no returns", "other angles", "one standstill"],
)
def test_only_returns_to_the_same_angles_make_a_jitter_sure(settings, sure):
    """Random errors at 60 poses, each visited twice, are a jitter; the same errors at both visits are not, and without returns it is open."""
    most = most_confidence_at_returns(*campaign(**{"poses": 60, "visits": 2, "seed": 7} | settings))
    assert most == (1.0 if sure else NOT_SURE)


def test_a_confidence_that_is_lowered_states_the_rule(monkeypatch):
    """Without returns a jitter's limit states that none bear it out; if neither half shows it either, the lower limit and its reason are stated."""
    monkeypatch.setattr(limits_of_noise, "excludes_smooth_error", lambda *_: True)
    monkeypatch.setattr(limits_of_noise, "most_confidence_in_time", lambda *_: 1.0)
    state, component = campaign(200, 1, 0.0, 7)
    assert limit_of_noise(state, component, None, beside_structure=False) == (NOT_SURE, NO_RETURNS)
    halves: Any = SimpleNamespace(answers=[1, 2], noise_selected_in=lambda name: 0.0)
    most, reason = limit_of_noise(state, component, halves, beside_structure=False)
    assert most == 0.25 and reason.startswith("neither half of the poses shows it")


def test_an_error_of_whole_scans_is_not_concerned():
    """A hose moves no scan about a place of its own: the confidence in a bias of the scans stays."""
    state, component = campaign(60, 1, 0.0, 1)
    other = VarianceComponent("scan_bias", STD, 1e-5, 50.0, 1e-9, component.covariance)
    assert most_confidence_at_returns(state, other) == 1.0
