"""A reflector that was exchanged during a campaign is named with the pose and the distance; a column ``target`` then separates the two places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.sensor.exchanged_target import exchanged_targets
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.units import MM
from tests.random_scene import make_scene
from tests.workcell import Scene

SHIFT = np.array([0.02, -0.01, 0.02])  # 30 mm


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7)


def exchanged(scene: Scene, k: int):
    """Return the dataset whose target sits ``SHIFT`` away in the sensor's frame from row ``k`` on."""
    dataset, truth = scene.dataset, scene.truth
    R = truth.T_tracker_base[:3, :3] @ truth.sensor(dataset.q[k:])[:, :3, :3]
    points = dataset.points.copy()
    points[k:] += R @ SHIFT
    return replace(dataset, points=points)


@pytest.mark.parametrize("k", [33, pytest.param(60, marks=pytest.mark.slow)])
def test_an_exchanged_target_is_named_with_pose_and_distance(scene, k):
    """The pose is the first with the other target and the distance is the true one; with names of their own, both are calibrated."""
    dataset = exchanged(scene, k)
    with pytest.raises(WrongSetup) as refused:
        calibrate(dataset)
    (suspicion,) = refused.value.suspicions
    assert suspicion.what == "exchanged_target" and suspicion.where == f"pose {dataset.pose_ids[k]}"
    assert suspicion.file_at_fault == "points.csv"
    assert "30 mm from where it sat" in suspicion.sentence
    assert "a column target into points.csv" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.5 * MM
    named = replace(
        dataset,
        targets=("one", "other"),
        point_columns={"target": (np.arange(dataset.n_poses) >= k).astype(float)},
    )
    assert calibrate(named).residual_rms < 0.5 * MM


def test_only_a_tracker_has_targets_that_may_be_exchanged(scene):
    """Scans and probed points know no targets on the flange; measurements that are farther off than a flange is large are passed over."""
    scanned = make_scene("vs060", poses_per_plane=8, points_per_scan=12, seed=7)
    assert list(exchanged_targets(scanned.dataset)) == []
    shuffled = replace(scene.dataset, points=scene.dataset.points[::-1])
    assert list(exchanged_targets(shuffled)) == []
