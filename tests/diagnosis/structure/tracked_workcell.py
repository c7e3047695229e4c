"""An arm before a tracker, with something wrong that nobody declared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from tests.effects.injected import Flaws, PoseData, true_frames
from tests.random_scene import make_scene


def tracked(robot: str, flaws: Flaws, seed: int, noise: float, poses: int) -> Dataset:
    """Return poses of an arm of ``configs/robots`` before a tracker with some noise along each axis [m]."""
    scene = make_scene(
        robot,
        "tracker",
        seed=seed,
        poses_per_plane=poses // 3,
        noise=noise,
        length_error=5e-4,
        angle_error=1e-3,
    )
    data, truth = scene.dataset, scene.truth
    at = PoseData(data.q, np.arange(float(data.n_poses)), {})
    place = true_frames(truth, flaws, at, np.zeros_like(data.q))[:, :3, 3]
    points = place @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
    return replace(
        data, points=points + noise * np.random.default_rng([seed, 5]).standard_normal(points.shape)
    )
