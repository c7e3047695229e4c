"""A target that stands elsewhere from some pose on is named with that pose; a column ``session`` then separates the two places."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.unrelated_rows import unrelated
from scalar.geometry.se3 import exp_so3
from scalar.units import MM
from tests.random_scene import make_scene
from tests.workcell import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7)


def with_tracker_moved(dataset: Dataset, k: int, shift: float) -> Dataset:
    """Return the dataset with the tracker at another place, ``shift`` [m] away and turned by as many rad, from row ``k`` on."""
    points = dataset.points.copy()
    points[k:] = points[k:] @ exp_so3([0.0, shift, -shift]).T + [shift, 0.0, 0.0]
    return replace(dataset, points=points)


def named_pose(dataset: Dataset) -> int:
    """Return the pose that the refusal of a dataset says the target moved at."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(dataset)
    (suspicion,) = refused.value.suspicions
    assert suspicion.what == "moved_target" and suspicion.robot is None
    assert suspicion.file_at_fault == "poses.csv"
    assert "the residual falls from" in suspicion.sentence and "column session" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.5 * MM
    return int(re.search(r"from pose (\d+) on", suspicion.sentence)[1])


@pytest.mark.parametrize(
    ("k", "shift"), [(33, 0.5), *(pytest.param(*c, marks=pytest.mark.slow) for c in ((12, 1.0), (61, 0.05)))]
)
def test_a_tracker_that_moved_is_named_with_the_pose(scene, k, shift):
    """The pose is the first after the move, and with the column that is advised the dataset is calibrated."""
    moved = with_tracker_moved(scene.dataset, k, shift)
    assert named_pose(moved) == moved.pose_ids[k]
    session = np.where(np.arange(moved.n_poses) < k, 1, 2)
    assert calibrate(replace(moved, poses=moved.poses.assign(session=session))).residual_rms < 0.5 * MM


def test_a_tracker_that_went_to_the_other_side_is_named_with_the_pose():
    """It then measures in so different a frame that the angles explain no more of the places than in random order; the move is named all the same."""
    dataset = make_scene("panda", "tracker", poses_per_plane=30, noise=1e-4, seed=4).dataset
    points = dataset.points.copy()
    points[50:] = points[50:] @ exp_so3([0.1, 0.2, 2.5]).T + [2.0, -3.0, 0.5]
    moved = replace(dataset, points=points)
    assert unrelated(moved)
    assert named_pose(moved) == moved.pose_ids[50]


@pytest.mark.slow
def test_an_arm_that_was_moved_between_planes_is_named_with_the_pose():
    """With planes, all of them stand elsewhere relative to the base."""
    one = make_scene("vs060", poses_per_plane=25, points_per_scan=12, noise=1e-4, seed=7)
    planes = (
        one.truth.normals @ exp_so3([0.05, 0.0, 0.1]),
        one.truth.distances + np.array([0.05, 0.03, -0.04]),
    )
    other = make_scene(
        "vs060", poses_per_plane=20, points_per_scan=12, noise=1e-4, seed=8, target_planes=planes
    )
    poses = pd.concat([one.dataset.poses, other.dataset.poses], ignore_index=True)
    both = replace(
        one.dataset,
        poses=poses.assign(pose=np.arange(1, len(poses) + 1)),
        points=np.concatenate([one.dataset.points, other.dataset.points]),
        starts=np.r_[one.dataset.starts, other.dataset.starts[1:] + one.dataset.starts[-1]],
    )
    assert named_pose(both) == 76


@pytest.mark.slow
def test_a_target_that_slipped_on_the_flange_is_no_tracker_that_moved(scene):
    """Another place of the tracker does not explain another place of the target on the flange."""
    dataset, truth = scene.dataset, scene.truth
    T = truth.sensor(dataset.q[40:])
    slipped = T[:, :3, 3] + T[:, :3, :3] @ [0.05, -0.03, 0.04]
    points = dataset.points.copy()
    points[40:] = slipped @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(dataset, points=points))
    assert [suspicion.what for suspicion in refused.value.suspicions] == ["exchanged_target"]


@pytest.mark.slow
def test_another_robot_is_no_tracker_that_moved(scene):
    """A table of joints that fits no part of the poses is not explained by a place for each part; the arm that was measured is named."""
    other = make_scene("ur10e", "tracker", poses_per_plane=2).dataset.robot
    with pytest.raises(WrongSetup, match="denso_vs060"):
        calibrate(replace(scene.dataset, robot=other))
