"""An arm before a tracker, with something wrong that nobody declared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from tests.effects.injected import Flaws, PoseData, true_frames
from tests.random_scene import make_scene
from tests.workcell import Scene


def workcell(robot: str, seed: int, noise: float, poses: int) -> Scene:
    """Return an arm of ``configs/robots`` before a tracker with some noise along each axis [m], nothing wrong with it."""
    each = poses // 3
    return make_scene(
        robot, "tracker", seed=seed, poses_per_plane=each, noise=noise, length_error=5e-4, angle_error=1e-3
    )


def tracked(robot: str, flaws: Flaws, seed: int, noise: float, poses: int) -> Dataset:
    """Return what the tracker measures of the arm of ``workcell`` if it has flaws."""
    scene = workcell(robot, seed, noise, poses)
    data, truth = scene.dataset, scene.truth
    at = PoseData(data.q, np.arange(float(data.n_poses)), {})
    place = true_frames(truth, flaws, at, np.zeros_like(data.q))[:, :3, 3]
    points = place @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
    scatter = noise * np.random.default_rng([seed, 5]).standard_normal(points.shape)
    return replace(data, points=points + scatter)
