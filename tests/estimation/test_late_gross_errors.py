"""Thresholds of gross errors that are looked for once effects are modelled; each is tested with data on both sides of it."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.gross_errors import Cleaned, clean_given_effects
from scalar.estimation.settings import DEFAULTS
from scalar.units import MM
from tests.random_scene import make_scene

GROSS = DEFAULTS.gross_errors
POSE, USUAL = 50, 0.1 * MM


@pytest.fixture(scope="module")
def tracked():
    """Return a hundred tracked poses whose first joint takes equidistant angles in a random order."""
    dataset = make_scene("vs060", "tracker", seed=3, poses_per_plane=34, noise=1e-4).dataset.subset(
        np.arange(100)
    )
    angles = 0.02 * np.random.default_rng(1).permutation(100)
    return replace(dataset, poses=dataset.poses.assign(q1=angles))


def neighbours(dataset, pose):
    """Return the other poses, those with the nearest first angle first."""
    apart = np.abs(dataset.q[:, 0] - dataset.q[pose, 0])
    apart[pose] = np.inf
    return np.argsort(apart, kind="stable")


def is_set_aside(dataset, by, usual=USUAL, near=0, near_by=0.0, **factors):
    """Return whether a pose that is off ``by`` [m] is set aside where the others are off as usual, and ``near`` neighbours by ``near_by`` [m]."""
    distance = np.full(100, usual)
    distance[neighbours(dataset, POSE)[:near]] = near_by
    distance[POSE] = by
    scaled = {
        name: type(getattr(GROSS, name))(getattr(GROSS, name) * factor) for name, factor in factors.items()
    }
    found = clean_given_effects(Cleaned(dataset, (), (), 0), distance, settings=replace(GROSS, **scaled))
    assert found.outlier_poses in ((), (int(dataset.pose_ids[POSE]),))
    return bool(found.outlier_poses)


def test_how_far_off_a_pose_may_be_late(tracked):
    """With others off by 0.1 mm, 0.6 mm is kept and 1 mm set aside; half or double the factor changes one of these decisions."""
    assert not is_set_aside(tracked, 0.6 * MM)
    assert is_set_aside(tracked, 0.6 * MM, late_sigmas=0.5)
    assert is_set_aside(tracked, 1.0 * MM)
    assert not is_set_aside(tracked, 1.0 * MM, late_sigmas=2.0)


def test_no_pose_is_set_aside_late_that_is_off_by_less_than_an_arm_repeats(tracked):
    """With others hardly off at all, 0.15 mm is kept and 0.3 mm set aside; half or double the limit changes one of these decisions."""
    assert not is_set_aside(tracked, 0.15 * MM, usual=1e-6)
    assert is_set_aside(tracked, 0.15 * MM, usual=1e-6, least_late_error=0.5)
    assert is_set_aside(tracked, 0.3 * MM, usual=1e-6)
    assert not is_set_aside(tracked, 0.3 * MM, usual=1e-6, least_late_error=2.0)


def test_how_many_similar_poses_are_looked_at(tracked):
    """Two neighbours that are off are a minority of six and a majority of three; four are a majority of six and a minority of twelve."""
    assert is_set_aside(tracked, 1 * MM, near=2, near_by=0.3 * MM)
    assert not is_set_aside(tracked, 1 * MM, near=2, near_by=0.3 * MM, similar_poses=0.5)
    assert not is_set_aside(tracked, 1 * MM, near=4, near_by=0.3 * MM)
    assert is_set_aside(tracked, 1 * MM, near=4, near_by=0.3 * MM, similar_poses=2.0)


def test_how_far_off_similar_poses_have_to_be(tracked):
    """Neighbours off by three times the usual distance show structure, and by one and a half times none."""
    assert not is_set_aside(tracked, 1 * MM, near=6, near_by=0.3 * MM)
    assert is_set_aside(tracked, 1 * MM, near=6, near_by=0.3 * MM, similar_ratio=2.0)
    assert is_set_aside(tracked, 1 * MM, near=6, near_by=0.15 * MM)
    assert not is_set_aside(tracked, 1 * MM, near=6, near_by=0.15 * MM, similar_ratio=0.5)


def test_the_tail_of_one_law_is_no_gross_error(tracked):
    """One pose that is off is set aside beside two half-way to the limit, and kept beside three; one off by 2 mm is set aside beside both."""
    for near, by, expected in ((2, 1.0, True), (3, 1.0, False), (2, 2.0, True), (3, 2.0, True)):
        distance = np.full(100, USUAL)
        distance[np.argsort(tracked.q[:, 0])[:: 100 // near][:near]] = 0.5 * MM
        distance[POSE] = by * MM
        found = clean_given_effects(Cleaned(tracked, (), (), 0), distance)
        assert found.outlier_poses == ((int(tracked.pose_ids[POSE]),) if expected else ())


def test_poses_between_two_changes_are_set_aside_however_near_they_are(tracked):
    """What an effect explains by two changes leaves no residual; the poses between them are told by a mask."""
    distance, brief = np.full(100, USUAL), np.zeros(100, dtype=bool)
    brief[20:22] = True
    found = clean_given_effects(Cleaned(tracked, (), (), 0), distance, brief)
    assert found.outlier_poses == tuple(int(i) for i in tracked.pose_ids[20:22])
