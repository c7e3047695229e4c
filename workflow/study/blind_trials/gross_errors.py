"""Gross errors that measured sets have: stray points, poses whose joint angles are wrong, wrong labels.

None of them is an effect; a diagnosis is to set them aside and to name nothing because of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

STRAY = (2 * MM, 30 * MM)  # how far a stray point is off, either way
CORRUPTED_RAD = (0.05, 0.5)  # how far each joint of a corrupted pose is off, either way


def with_gross_errors(
    dataset: Dataset, gross_errors: Mapping[str, float], rng: np.random.Generator
) -> tuple[Dataset, list[int]]:
    """Return a dataset with gross errors, and the ids of the poses that are wrong as a whole.

    Args:
        dataset: Of a line laser; stays as it is.
        gross_errors: Shares of ``points``, ``poses`` and ``labels``.
        rng: Chooses.
    """
    N = dataset.n_poses
    n_corrupted, n_labels = (round(gross_errors.get(key, 0.0) * N) for key in ("poses", "labels"))
    corrupted, mislabelled = np.split(rng.permutation(N)[: n_corrupted + n_labels], [n_corrupted])
    points, poses = dataset.points.copy(), dataset.poses.copy()
    stray = np.flatnonzero(rng.random(len(points)) < gross_errors.get("points", 0.0))
    away = rng.uniform(*STRAY, len(stray)) * rng.choice([-1.0, 1.0], len(stray))
    points[stray] *= (1.0 + away / np.linalg.norm(points[stray], axis=1))[:, None]
    names = [f"q{j + 1}" for j in range(dataset.robot.n_joints)]
    q = poses[names].to_numpy(copy=True)
    q[corrupted] += rng.uniform(*CORRUPTED_RAD, (len(corrupted), q.shape[1])) * rng.choice(
        [-1.0, 1.0], (len(corrupted), q.shape[1])
    )
    poses[names] = q
    planes = [plane.name for plane in dataset.planes]
    labels = poses["plane"].to_numpy(dtype=object).copy()
    for i in mislabelled:
        labels[i] = rng.choice([name for name in planes if name != labels[i]])
    poses["plane"] = labels
    wrong = sorted(int(i) for i in dataset.pose_ids[np.r_[corrupted, mislabelled].astype(int)])
    return replace(dataset, points=points, poses=poses), wrong
