"""A joint that was not logged for some poses is named in place of the poses."""

from dataclasses import replace

import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.stuck_joint import stuck_joint_in_words
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked():
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def with_joint(dataset, joint, rows, value):
    """Return the dataset in which a joint (from 1) is logged at one position in some rows."""
    q = dataset.q[:, joint - 1].copy()
    q[rows] = value
    return replace(dataset, poses=dataset.poses.assign(**{f"q{joint}": q}))


def test_the_joint_its_position_and_the_poses_are_named(tracked):
    stuck = with_joint(tracked, 5, slice(60, 75), 0.4)
    first, last = tracked.pose_ids[[60, 74]]
    words = f"joint 5 has the same position, 22.9183 degrees, from pose {first} to pose {last}"
    with pytest.raises(InvalidInput, match=words) as refused:
        calibrate(stuck)
    assert len(refused.value.faults) == 1


def test_a_joint_that_stands_still_while_poses_agree_is_not_named(tracked):
    """Nor is one where the poses that contradict the others are elsewhere."""
    still = with_joint(tracked, 5, slice(60, 75), 0.4)
    assert not stuck_joint_in_words(still, [])
    assert not stuck_joint_in_words(still, list(tracked.pose_ids[:8]))
    assert not stuck_joint_in_words(tracked, list(tracked.pose_ids[60:75]))


def test_a_diagnosis_that_sets_the_poses_aside_says_it_too(tracked):
    """The joint is named in the set-up, in place of a change of the arm."""
    found = diagnose(with_joint(tracked, 5, slice(63, 75), 0.4))
    assert [one["what"] for one in found.setup] == ["stuck_joint"]
