"""A joint that was not logged for some poses is named in place of the poses."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.tables.stuck_joint import stands_still_for_long, stuck_joint_in_words
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


def test_a_joint_that_stands_still_for_long_is_asked_about(tracked):
    """If its position never recurs elsewhere; not in a short run, on a grid, or where joints move one at a time."""
    said = stands_still_for_long(with_joint(tracked, 6, slice(45, 75), 0.2))
    assert "joint 6 has the same position in the 30 poses" in said
    assert not stands_still_for_long(with_joint(tracked, 6, slice(67, 75), 0.2))
    grid = with_joint(tracked, 6, slice(None), np.repeat([0.1, 0.4, 0.2, 0.3, 0.5], 15))
    assert not stands_still_for_long(grid)
    q = np.tile(tracked.q[:1], (tracked.n_poses, 1))
    for j in range(6):
        q[12 * j : 12 * (j + 1), j] += np.linspace(0.1, 1.2, 12)
    one_at_a_time = {f"q{j + 1}": q[:, j] for j in range(6)}
    assert not stands_still_for_long(replace(tracked, poses=tracked.poses.assign(**one_at_a_time)))
