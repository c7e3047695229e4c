"""In which unit points are written that cannot be metres.

The scatter of a tracker's points is compared with that of the nominal flange. Of a scan only its size is known: numbers that as millimetres would be
nearer than most scanners measure may be centimetres.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scalar.data.description import Description
from scalar.data.located_table import Table
from scalar.data.sensor_formats import MeasuredTable
from scalar.data.unit_suspicions import write_si
from scalar.geometry.robot import Robot
from scalar.units import MM

_UNITS = {"millimetres": MM, "centimetres": 10.0 * MM, "inches": 25.4 * MM}
_NEAR = 50 * MM  # chosen: hardly any scanner measures nearer
_FITS = 1.6  # factor; chosen: half of the least ratio of two units, in logarithms. An offset of the target changes the scatter by less


def advice_on_points(
    points: Table, poses: Table | None, description: Description, layout: MeasuredTable
) -> Callable[[str, str], str]:
    """Return what to do about points that look like another unit, for ``suspect_points``: with the unit that they are in, if that can be told.

    Args:
        points: The table of points.
        poses: The table of poses; None if it could not be read.
        description: The description; one with faults tells no unit.
        layout: Of the table of points. Only points in a fixed frame, one for each pose and target, tell a unit.
    """

    def advice(unit: str, column: str) -> str:
        if unit == "m" and column in layout.units and (name := _unit(points, poses, description, layout)):
            return f"are these {name}? write metres"
        if unit == "m" and layout.several_rows and 1.0 < _farthest(points, layout) < _NEAR / MM:
            return "are these millimetres or centimetres? write metres"
        return write_si(unit)

    return advice


def _unit(points: Table, poses: Table | None, description: Description, layout: MeasuredTable) -> str | None:
    """Return the name of the unit in which the points scatter as the nominal flange does; None if there is none."""
    joints = [f"q{i + 1}" for i in range(description.n_joints)]
    axes = [name for name, unit in layout.units.items() if unit == "m"]
    in_fixed_frame = not layout.several_rows and len(axes) == 3
    if poses is None or description.faults or not in_fixed_frame:
        return None
    if not (poses.good("pose", *joints) and points.good("pose", *axes)):
        return None
    rows = {pose: i for i, pose in enumerate(poses.columns["pose"].tolist())}
    row = np.array([rows.get(pose, -1) for pose in points.columns["pose"].tolist()], dtype=int)
    xyz = np.column_stack([points.columns[name] for name in axes])
    use = (row >= 0) & np.isfinite(xyz).all(axis=1)
    if not use.any():
        return None
    robot = Robot.from_mapping(description.mapping["robot"])
    q = np.column_stack([poses.columns[name] for name in joints])[row[use]]
    expected, measured = _scatter(robot.flange(q)[:, :3, 3]), _scatter(xyz[use])
    for name, size in _UNITS.items():
        if expected / _FITS < measured * size < expected * _FITS:
            return name
    return None


def _farthest(points: Table, layout: MeasuredTable) -> float:
    """Return the median of the finite numbers of that coordinate in which it is largest, whatever their unit; 0 if there are none."""
    sizes = [np.abs(points.columns[name]) for name in layout.units if name in points.columns]
    return max(
        (float(np.median(size[np.isfinite(size)])) for size in sizes if np.isfinite(size).any()), default=0.0
    )


def _scatter(points: np.ndarray) -> float:
    """Return the root mean square distance of points ``(P, 3)`` from their mean."""
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))
