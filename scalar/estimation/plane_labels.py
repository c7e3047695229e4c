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
    # A target is a plane in one session. Only other planes of a pose's own session are tried: if it fits one of another session, its label is right.
    targets = measurement.initial_target(dataset).names
    labelled = dataset.poses["plane"].to_numpy(dtype=object)
    indices = {name: k for k, name in enumerate(planes.names)}
    own = np.array([indices.get(targets[k], -1) for k in measurement.target_index])
    limit = outlier_limit(
        pose_distances(measurement, T, planes, np.maximum(own, 0))[keep & (own >= 0)], settings.gross_errors
    )
    every = np.stack(
        [pose_distances(measurement, T, planes, np.full(dataset.n_poses, k)) for k in range(len(indices))],
        axis=1,
    )
    labels = {}
    for i in off:
        session = targets[measurement.target_index[i]].removeprefix(str(labelled[i]))
        others = {
            plane.name: float(every[i, indices[f"{plane.name}{session}"]])
            for plane in dataset.planes
            if plane.name != labelled[i] and f"{plane.name}{session}" in indices
        }
        best = min(others, key=lambda name: others[name], default=None)
        mine = float(every[i, own[i]]) if own[i] >= 0 else np.inf
        if best is not None and others[best] < min(limit, settings.gross_errors.label_ratio * mine):
            labels[int(i)] = best
    return labels
