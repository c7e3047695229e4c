"""Convert the table of measured points to the arrays of a dataset, in which the points are grouped by pose, and back."""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.located_table import Table
from scalar.data.sensor_formats import MeasuredTable, SensorFormat

if TYPE_CHECKING:
    import pandas as pd


def group_points(
    pose_ids: np.ndarray, format: SensorFormat, points: Table | None
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], tuple[str, ...]]:
    """Return the points of a table as arrays, in the order of the poses.

    Args:
        pose_ids: ``(N,)``, ids of the poses in the order of their rows.
        format: What a dataset with this kind of sensor holds.
        points: The table; None if the sensor has none.

    Returns:
        The points ``(P, k)`` in the units of the format, the index ``(N + 1,)`` at which those of each pose begin, the optional columns by name,
        ``(P,)`` each (a column of targets as indices of their names), and the names of the targets. These are `points`, `starts`,
        `point_columns` and `targets` of ``Dataset``.
    """
    if points is None or format.table is None:
        return np.empty((0, 2)), np.zeros(len(pose_ids) + 1, dtype=np.int64), {}, ()
    by_id = np.argsort(pose_ids, kind="stable")
    rows = by_id[np.searchsorted(pose_ids, points.columns["pose"].astype(np.int64), sorter=by_id)]
    xyz = np.column_stack([points.columns[name] for name in format.table.units])
    further = {name: points.columns[name] for name in format.table.further if name in points.columns}
    targets: tuple[str, ...] = ()
    if (item := format.table.item) in further:
        targets = tuple(dict.fromkeys(str(name) for name in further[item]))
        code = {name: i for i, name in enumerate(targets)}
        further[item] = np.array([code[str(name)] for name in further[item]], dtype=float)
    if np.any(np.diff(rows) < 0):
        by_row = np.argsort(rows, kind="stable")
        xyz, further = xyz[by_row], {name: values[by_row] for name, values in further.items()}
    counts = np.bincount(rows, minlength=len(pose_ids))
    return xyz, np.concatenate([[0], np.cumsum(counts)]).astype(np.int64), further, targets


def point_table(
    layout: MeasuredTable,
    row_pose_ids: np.ndarray,
    points: np.ndarray,
    point_columns: Mapping[str, np.ndarray],
    targets: Sequence[str],
) -> pd.DataFrame:
    """Return the table of the points, with the columns of the sensor kind's file.

    Args:
        layout: The table's columns.
        row_pose_ids: ``(P,)``, the id of the pose of each point.
        points: ``(P, k)``, as in ``Dataset``, in the units of the layout.
        point_columns: The optional columns, as in ``Dataset``.
        targets: The names of the targets on the flange, as in ``Dataset``.
    """
    import pandas as pd

    table = pd.DataFrame(points, columns=list(layout.units))
    table.insert(0, "pose", row_pose_ids)
    for name, values in point_columns.items():
        if name == layout.item:
            table.insert(1, name, np.array(targets, dtype=object)[values.astype(int)])
        else:
            table[name] = values
    return table
