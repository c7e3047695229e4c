"""Refuse data in which nothing moves, before a fit blames the robot for it."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.motion import faults_without_motion
from scalar.data.sensor_formats import sensor_formats
from scalar.errors import Fault, InvalidInput
from scalar.units import MM

# Standard deviation of the places of the nominal flange across the plane that fits them best.
_LEAST_OUT_OF_PLANE = 10 * MM
_SEVERAL = 5  # points; fewer may have a coordinate in common
_RETURNS = 3  # poses at each place on average, from which on the places are stated, as those of sockets, and may have a coordinate in common


def refuse_without_motion(dataset: Dataset) -> None:
    """Refuse a dataset whose poses, or whose points, are all the same, or whose points lack a coordinate.

    Raises:
        InvalidInput: All poses or all points are the same, or a coordinate is the same at every point.
    """
    table = sensor_formats()[dataset.sensor.kind].table
    items = dataset.point_columns.get("target")
    file = "points.csv" if table is None else table.files[0]
    faults = faults_without_motion(dataset.q, dataset.points, items, file)
    if faults := faults or _coordinates_filled_in(dataset, file):
        raise InvalidInput(faults)


def _coordinates_filled_in(dataset: Dataset, file: str) -> list[Fault]:
    """Return a fault for each coordinate that is the same number at every point, although the nominal arm moves in all three directions.

    A target that returns to a few places, whose coordinates are stated and not measured, may have one in common at all of them.
    """
    points = dataset.points[:, :3]
    if points.shape[1] != 3 or len(points) < _SEVERAL:
        return []
    same = np.flatnonzero(np.ptp(points, axis=0) == 0.0)
    if not len(same) or _RETURNS * len(np.unique(points, axis=0)) <= len(points):
        return []
    places = dataset.robot.flange(dataset.q)[:, :3, 3]
    smallest = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(places))
    if smallest < _LEAST_OUT_OF_PLANE:
        return []
    return [
        Fault(
            file,
            f"column {'xyz'[k]}: every value is {points[0, k] + 0.0:g} m, although the joints move the arm in all directions: it was probably "
            "filled in",
        )
        for k in same
    ]
