"""Poses that are labelled with one plane and lie on another."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.pose_consistency import outlier_limit, pose_distances
from scalar.estimation.settings import EstimationSettings
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import measure


def other_labels(
    dataset: Dataset, keep: Array, off: list[int], settings: EstimationSettings
) -> dict[int, str]:
    """Return the name of the plane on which a pose really lies, by the index of the pose; poses that lie on none are left out.

    Args:
        dataset: What was measured.
        keep: ``(N,)`` bool, the poses that agree with their labels.
        off: Indices of the poses that do not.
        settings: Thresholds.
    """
    if not dataset.planes or not len(off):
        return {}
    try:
        model, _ = geometry_fit(dataset.subset(keep), settings)
    except ScalarError:
        return {}
    planes = model.target
    assert isinstance(planes, Planes)
    T = dataset.robot.with_geometry(model.robot.geometry).flange(dataset.q) @ model.T_flange_sensor
    measurement = measure(dataset)
    every = np.stack(
        [
            pose_distances(measurement, T, planes, np.full(dataset.n_poses, k))
            for k in range(len(planes.names))
        ],
        axis=1,
    )[off]
    distances_own = pose_distances(measurement, T, planes, measurement.target_index)
    limit = outlier_limit(distances_own[keep], settings.gross_errors)
    own = [
        planes.names.index(name) if name in planes.names else -1
        for name in dataset.poses["plane"].to_numpy()[off]
    ]
    labels = {}
    for i, distances, mine in zip(off, every, own, strict=True):
        best = int(np.argmin(distances))
        near = distances[best] < limit
        if best != mine and near and distances[best] < settings.gross_errors.label_ratio * distances[mine]:
            labels[int(i)] = planes.names[best].split("@")[0]
    return labels
