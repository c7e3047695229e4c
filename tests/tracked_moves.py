"""A tracked arm that moves by short and long steps in turns, in a recorded order, with an error of one joint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from tests.kinematics import joint_names
from tests.random_scene import make_scene

LONGEST = 1.5  # rad
RANGE = 2.6  # rad, to either side at most


def tracked(
    error: Callable[[np.ndarray], np.ndarray],
    joint: int,
    seed: int,
    *,
    poses: int = 75,
    noise: float = 3e-5,
    shortest: float = 0.03,
) -> Dataset:
    """Return the dataset of an arm that walks through its joint space.

    Args:
        error: Of the joint [rad], from its angles ``(N,)`` [rad] in their order.
        joint: That errs, from 1.
        seed: Of everything.
        poses: Their number, a multiple of three.
        noise: Of the tracker along each axis [m].
        shortest: Step of a joint [rad]; steps are spread evenly on a logarithmic scale up to ``LONGEST``.
    """
    scene = make_scene(kind="tracker", seed=seed, poses_per_plane=poses // 3, noise=noise)
    truth, rng = scene.truth, np.random.default_rng([seed, 9])
    low, high = np.clip(truth.limits.T, -RANGE, RANGE)
    q = np.empty_like(scene.dataset.q)
    q[0] = (low + high) / 2
    for k in range(1, len(q)):
        step = np.exp(rng.uniform(np.log(shortest), np.log(LONGEST), q.shape[1])) * rng.choice(
            [-1, 1], q.shape[1]
        )
        outside = (q[k - 1] + step < low) | (q[k - 1] + step > high)
        q[k] = np.clip(q[k - 1] + np.where(outside, -step, step), low, high)
    stands = q.copy()
    stands[:, joint - 1] += error(q[:, joint - 1])
    points = truth.sensor(stands)[:, :3, 3] @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
    table = scene.dataset.poses.assign(
        order=np.arange(float(len(q))), **dict(zip(joint_names(q.shape[1]), q.T, strict=True))
    )
    return replace(scene.dataset, poses=table, points=points + noise * rng.standard_normal(points.shape))
