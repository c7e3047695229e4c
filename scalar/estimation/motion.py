"""Refuse data in which nothing moves, before a fit blames the robot for it."""

from __future__ import annotations

from scalar.data.dataset import Dataset
from scalar.data.motion import faults_without_motion
from scalar.data.sensor_formats import sensor_formats
from scalar.errors import InvalidInput


def refuse_without_motion(dataset: Dataset) -> None:
    """Refuse a dataset whose poses, or whose points, are all the same.

    Raises:
        InvalidInput: They are.
    """
    table = sensor_formats()[dataset.sensor.kind].table
    items = dataset.point_columns.get("target")
    file = "points.csv" if table is None else table.files[0]
    if faults := faults_without_motion(dataset.q, dataset.points, items, file):
        raise InvalidInput(faults)
