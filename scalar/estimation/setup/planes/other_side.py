"""Poses that were set aside and all lie as far to one side of their planes: plates that were touched from behind, or with another tip."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import point_heights
from scalar.estimation.residuals import Residuals
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.geometry.planes import Planes
from scalar.units import MM

_LEAST_POSES = 5  # chosen: fewer may be as far off by chance
_LEAST_SHARE = 0.8  # chosen, of the poses that were set aside: as many have to be as far off
_ALIKE = 0.2  # relative, chosen: by how much these distances may differ from their median
_LEAST = 0.5 * MM  # chosen: what is nearer is no plate's thickness


def other_side(dataset: Dataset, set_aside: Collection[int], model: Model) -> Suspicion | None:
    """Return the suspicion that some poses were measured on another side of the planes, or with another tip; None if they are not alike.

    Args:
        dataset: As it was given, before cleaning.
        set_aside: Ids of the poses that were set aside.
        model: Fitted to the others, without effects.
    """
    aside = np.isin(dataset.pose_ids, list(set_aside))
    planes = model.target
    if aside.sum() < _LEAST_POSES or not isinstance(planes, Planes):
        return None
    residuals = Residuals.of(dataset, model)
    measurement = residuals.measurement
    if measurement.target_index.max() >= len(planes.names):
        return None
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    of_points, starts = point_heights(measurement, T_base_sensor, planes, measurement.target_index)
    height = (np.add.reduceat(of_points, starts[:-1]) / np.diff(starts))[aside]
    typical = float(np.median(height))
    alike = np.abs(height - typical) < _ALIKE * abs(typical)
    if abs(typical) < _LEAST or np.mean(alike) < _LEAST_SHARE:
        return None
    ids = ", ".join(str(pose) for pose in dataset.pose_ids[aside][alike][:_LEAST_POSES])
    side = "in front of" if typical > 0 else "behind"
    behind = (
        "was another surface scanned there, as the other side of a plate or a cover on it"
        if measurement.scans
        else "were the plates touched from the other side there, or with another tip"
    )
    return Suspicion(
        "other_side",
        "poses.csv",
        f"{int(alike.sum())} of the {int(aside.sum())} poses that were set aside ({ids} and so on) all lie {in_mm(abs(typical))} mm {side} their "
        f"planes: {behind}? Give these a plane of their own in the column plane, or leave them out",
    )
