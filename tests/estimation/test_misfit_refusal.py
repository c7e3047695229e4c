"""Whether a refusal blames the description of the whole set-up, or asks about the few poses that are far off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.setup.refusal import misfit_refused
from scalar.units import MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked():
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def refusal(dataset, far):
    """Return the text of the refusal of a fit that leaves 2 mm at most poses, and ``far`` [mm] at the first ones."""
    distances = np.full(dataset.n_poses, 2.0 * MM)
    distances[: len(far)] = np.array(far) * MM
    return str(misfit_refused(dataset, distances))


def test_a_single_pose_that_is_far_off_is_asked_about(tracked):
    """One pose that is two centimetres off, where the others err by 2 mm, is no sign of another robot, and is named with its distance."""
    text = refusal(tracked, [20.6])
    assert f"pose {tracked.pose_ids[0]} lies 20.6 mm from" in text and "within 2.0 mm" in text
    assert "this is not the robot" not in text and "scalar diagnose" in text


def test_a_few_poses_are_named_the_worst_first(tracked):
    """Three poses are named in the order of their distances, and a dozen by the first eight."""
    ids = [int(pose) for pose in tracked.pose_ids]
    assert f"poses {ids[1]}, {ids[2]}, {ids[0]} lie up to 31.0 mm" in refusal(tracked, [12.0, 31.0, 20.0])
    assert " and 4 more lie up to" in refusal(tracked, [20.0 + k for k in range(12)])


def test_joints_beyond_their_limits_are_named_in_the_refusal(tracked):
    """Where many poses have a joint beyond its limits, the refusal asks for the order of the columns; a single pose asks for nothing."""
    far = [30.0] * tracked.n_poses
    assert "limits" not in refusal(tracked, far)
    for rows, said in ((1, False), (tracked.n_poses // 2, True)):
        turned = tracked.poses.copy()
        turned.loc[turned.index[:rows], "q3"] = tracked.robot.limits[2, 1] + 0.1
        text = refusal(replace(tracked, poses=turned), far)
        assert ("Joint 3 is beyond the limits in many poses" in text) == said


def test_where_most_poses_are_far_off_the_set_up_is_not_the_described_one(tracked):
    """If no part of the data fits, the description is blamed."""
    text = refusal(tracked, [30.0] * tracked.n_poses)
    assert "the best fit is still 30 mm RMS off" in text
    assert "this is not the robot or the sensor that dataset.yaml describes" in text
