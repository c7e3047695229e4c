"""Add gross errors to a dataset, as measured sets have them: stray points, poses whose joint angles are wrong, and wrong labels of planes.

None of them is an effect: a diagnosis should set them aside, and name no effect because of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

STRAY = (2 * MM, 30 * MM)  # [m], least and greatest error of a stray point's range, of either sign
CORRUPTED_RAD = (
    0.05,
    0.5,
)  # [rad], least and greatest error of each joint of a corrupted pose, of either sign


def with_gross_errors(
    dataset: Dataset, gross_errors: Mapping[str, float], rng: np.random.Generator
) -> tuple[Dataset, list[int]]:
    """Return a dataset with gross errors, and the ids of the poses that are wrong as a whole (wrong joint angles or a wrong label), ascending.

    Args:
        dataset: A dataset of a line laser; it is not changed.
        gross_errors: Shares of the points (``points``), poses (``poses``) and labels (``labels``) that become wrong; a missing one is zero.
        rng: Draws which of them become wrong, and by how much.
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
