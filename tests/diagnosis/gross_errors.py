"""Datasets with gross errors: stray points, joint angles of another pose, wrong plane labels."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from tests.kinematics import joint_names


def spoiled(
    dataset: Dataset,
    rng: np.random.Generator,
    *,
    points: float = 0.0,
    poses: float = 0.0,
    labels: float = 0.0,
) -> tuple[Dataset, dict[str, Any]]:
    """Return a dataset with gross errors, and which these are.

    Args:
        dataset: The dataset without gross errors.
        rng: Draws the points and poses that are spoiled.
        points: Share of the points that are off by 2 to 30 mm along their rays.
        poses: Share of the poses whose joint angles are replaced by wrong ones.
        labels: Share of the poses whose label names another target plane.
    """
    cloud, frame = dataset.points.copy(), dataset.poses.copy()
    N = dataset.n_poses
    corrupted = rng.choice(N, round((poses + labels) * N), replace=False)
    wrong_poses, wrong_labels = np.split(corrupted, [round(poses * N)])
    stray = np.flatnonzero(rng.random(len(cloud)) < points)
    r = np.linalg.norm(cloud[stray], axis=1, keepdims=True)
    away = rng.uniform(2e-3, 3e-2, (len(stray), 1)) * rng.choice([-1.0, 1.0], (len(stray), 1))
    cloud[stray] *= 1 + away / r
    joints = joint_names(dataset.q.shape[1])
    angles = frame[joints].to_numpy(copy=True)
    angles[wrong_poses] += rng.uniform(0.05, 0.5, (len(wrong_poses), angles.shape[1]))
    frame[joints] = angles
    names = [plane.name for plane in dataset.planes]
    plane = frame["plane"].to_numpy(dtype=object).copy()
    for i in wrong_labels:
        plane[i] = rng.choice([name for name in names if name != plane[i]])
    frame["plane"] = plane
    ids = dataset.pose_ids
    injected = {
        "poses": set(ids[wrong_poses].tolist()),
        "labels": set(ids[wrong_labels].tolist()),
        "points": stray,
    }
    return replace(dataset, points=cloud, poses=frame), injected
