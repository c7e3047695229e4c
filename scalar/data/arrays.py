"""A dataset from arrays in memory: they are put into the tables that a folder would hold, and checked by the same rules.

A fault names the table, the row (counted from 1) and the column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from scalar.data.description import Description, check_description
from scalar.data.folder import Content
from scalar.data.located_table import Layout, Table, check_cells, header_faults
from scalar.data.references import References
from scalar.data.sensor_formats import sensor_formats
from scalar.data.table_consistency import (
    check_points,
    check_poses,
    is_name,
    not_a_name,
    points_layout,
    poses_layout,
)
from scalar.data.unit_suspicions import (
    suspect_description,
    suspect_joint_angles,
    suspect_points,
)
from scalar.errors import Fault, InvalidInput


def content_of_arrays(
    mapping: dict[str, Any],
    q: ArrayLike,
    points: Any,
    plane: Sequence[str] | None,
    pose_ids: ArrayLike | None,
    columns: Mapping[str, ArrayLike],
    point_columns: Mapping[str, Any],
) -> Content:
    """Return the content of the folder that would hold these arrays.

    Args:
        mapping: the content of dataset.yaml.
        q: ``(N, n)`` [rad; m for a prismatic joint], joint angles as the encoders read them.
        points: ``(N, k)``, ``(N, M, k)`` or N arrays ``(M_i, k)`` [m]; None for a sensor without a table of points.
        plane: ``(N,)`` names of planes; None for a sensor that measures no planes.
        pose_ids: ``(N,)`` integers; 1 to N if None.
        columns: further columns of poses.csv by name, ``(N,)`` each; ``approach`` may be ``(N, n)``.
        point_columns: further columns of the points by name, ``(P,)`` each.

    Raises:
        InvalidInput: with all the faults found.
    """
    description = Description(mapping, {}, "dataset")
    check_description(description)
    suspect_description(description)
    faults = description.faults
    angles = np.asarray(q, dtype=float)
    if angles.ndim != 2 or angles.shape[1] != description.n_joints:
        shape = f"of shape {angles.shape}; the robot needs (poses, {description.n_joints})"
        raise InvalidInput([*faults, Fault("poses", shape, None, "q")])
    ids = np.arange(1, len(angles) + 1) if pose_ids is None else np.asarray(pose_ids)
    layout = poses_layout(description)
    poses = _poses(angles, ids, plane, columns, layout, faults)
    if poses is not None:
        check_poses(poses, description, faults)
        suspect_joint_angles(poses, description, faults)
    table = None
    if description.sensor_format is not None:
        table = _points(points, ids, description, point_columns, faults)
        if table is not None and description.sensor_format.table is not None:
            check_points(table, poses, description.sensor_format.table, faults)
            suspect_points(table, description.sensor_format.table, faults)
    if faults or poses is None:
        raise InvalidInput(faults)
    return Content(mapping, poses, table)


def references_of_arrays(nests: Mapping[str, ArrayLike], n_poses: int, kind: str) -> References | None:
    """Return the references of arrays ``(N, 3)`` [m] by name, checked as strictly as nests.csv is; None if there are none.

    Args:
        nests: The arrays; a row that is not finite was not measured.
        n_poses: Number N of poses.
        kind: Of the sensor.

    Raises:
        InvalidInput: With all the faults found.
    """
    if not nests:
        return None
    if sensor_formats()[kind].references is None:
        raise InvalidInput(Fault("nests", f"a {kind} measures no points on the base; leave them out"))
    faults: list[Fault] = []
    for name, values in nests.items():
        if not is_name(name):
            faults.append(Fault("nests", not_a_name(name), None, name))
        elif (shape := np.shape(values)) != (n_poses, 3):
            faults.append(
                Fault(
                    "nests",
                    f"of shape {shape}; write ({n_poses}, 3), NaN where it was not measured",
                    None,
                    name,
                )
            )
    if faults:
        raise InvalidInput(faults)
    return References.of_arrays(nests)


def _table(file: str, columns: dict[str, np.ndarray]) -> Table:
    rows = len(next(iter(columns.values())))
    return Table(file, columns, lambda: np.arange(1, rows + 1))


def _poses(
    q: np.ndarray,
    ids: np.ndarray,
    plane: Sequence[str] | None,
    extra: Mapping[str, ArrayLike],
    layout: Layout,
    faults: list[Fault],
) -> Table | None:
    """Return the table of poses; None if a column does not have one value for each pose, or may not be there."""
    given: dict[str, Any] = {"pose": ids}
    if plane is not None:
        given["plane"] = plane
    given |= {f"q{i + 1}": column for i, column in enumerate(q.T)}
    for name, values in extra.items():
        if name == "approach":
            given |= {f"approach{i + 1}": column for i, column in enumerate(np.asarray(values).T)}
        else:
            given[name] = values
    columns: dict[str, np.ndarray] = {}
    wrong: list[Fault] = []
    for name, values in given.items():
        try:
            column = np.array(values, dtype=object if name in layout.text else float)
        except (TypeError, ValueError):
            wrong.append(Fault("poses", "not a number for each pose", None, name))
            continue
        if name in layout.text:
            column = np.array([str(value).strip() for value in column], dtype=object)
        if column.shape != (len(q),):
            wrong.append(Fault("poses", f"of shape {column.shape}; write ({len(q)},)", None, name))
        columns[name] = column
    return _checked_table("poses", columns, layout, wrong, faults)


def _points(
    points: Any,
    ids: np.ndarray,
    description: Description,
    further: Mapping[str, Any],
    faults: list[Fault],
) -> Table | None:
    """Return the table of points; None if the sensor has none, or if the arrays do not fit its layout."""
    format = description.sensor_format
    assert format is not None
    kind = format.kind
    if format.table is None:
        if points is not None:
            faults.append(Fault("points", f"a {kind} has no points; leave them out"))
        return None
    names, units = format.table.columns, ",".join(dict.fromkeys(format.table.units.values()))
    if points is None:
        faults.append(
            Fault("points", f"missing; a {kind} needs {','.join(names[1:])} [{units}] for each pose")
        )
        return None
    of_poses = [np.atleast_2d(np.asarray(each, dtype=float)) for each in points]
    width = len(names) - 1
    if len(of_poses) != len(ids):
        faults.append(Fault("points", f"points of {len(of_poses)} poses; q has {len(ids)}"))
        return None
    misfits = [i for i, each in enumerate(of_poses) if each.ndim != 2 or each.shape[1] != width]
    if misfits:
        shape = f"points of shape {of_poses[misfits[0]].shape}; a {kind} needs (points, {width})"
        faults.append(Fault("points", shape, misfits[0] + 1))
        return None
    owner = np.repeat(ids, [len(each) for each in of_poses]).astype(float)
    stacked = np.concatenate(of_poses) if of_poses else np.empty((0, width))
    layout = points_layout(format.table, description)
    columns = {"pose": owner, **dict(zip(names[1:], stacked.T, strict=True))}
    for name, values in further.items():
        text = name in layout.text
        column = np.array([str(v).strip() for v in values] if text else values, object if text else float)
        if column.shape != owner.shape:
            faults.append(Fault("points", f"of shape {column.shape}; write ({len(owner)},)", None, name))
            return None
        columns[name] = column
    return _checked_table("points", columns, layout, [], faults)


def _checked_table(
    name: str, columns: dict[str, np.ndarray], layout: Layout, wrong: list[Fault], faults: list[Fault]
) -> Table | None:
    """Return the table of checked columns; None if columns are missing, or if some were at fault already.

    Args:
        name: What messages call the table.
        columns: Its columns.
        layout: What they have to be.
        wrong: Faults of columns that were found before.
        faults: Every fault is added here.
    """
    wrong = [*wrong, *header_faults(name, list(columns), layout, None)]
    faults += wrong
    if wrong:
        return None
    table = _table(name, columns)
    check_cells(table, layout, faults)
    return table
