"""Lines of ``scalar validate`` on what is no fault and looks like one: joints beyond their limits or without motion, wrong units, copies."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.copies import copies_in_words
from scalar.data.covariates import misspelt_columns
from scalar.data.formats import IMPORTED
from scalar.data.motion import faults_without_motion, still_in_words, still_joints
from scalar.data.record_units import units_suspected
from scalar.geometry.robot import Robot
from scalar.robots import doubt_of_name, largest_payload
from scalar.units import DEG, unit_of_joint

if TYPE_CHECKING:
    from scalar.data.folder import Content
    from scalar.data.located_table import Table
    from scalar.data.sensor_formats import MeasuredTable

WARNING = "warning:"
"""Begins a line on what is probably wrong; what may be right is a note."""
_SEVERAL = 10  # poses from which their angles are looked at
_TWO_TURNS_AS_DEGREES = 4.0 * math.pi * DEG  # rad
_BEYOND = 1e-3  # rad or m: limits and angles may be rounded by as much


def notes_on(content: Content, layout: MeasuredTable | None) -> list[str]:
    """Return the lines on a dataset without a fault.

    Args:
        content: Of the folder.
        layout: Of its table of measurements; None for a sensor without one.
    """
    poses, points, joints = content.poses, content.points, content.mapping["robot"]["joints"]
    q = np.column_stack([poses.columns[f"q{i + 1}"] for i in range(len(joints))])
    still = _without_motion(q, points, layout)
    lines = still or _small_angles(poses, joints)
    converted = content.mapping.get(IMPORTED, {}).get("joints", "")
    lines += _beyond_limits(q, poses.columns["pose"], joints, converted)
    lines += _name_of_arm(content.mapping["robot"])
    rated = largest_payload(str(content.mapping["robot"].get("name", "")))
    lines += [f"  {WARNING} poses.csv: {clause}" for clause in units_suspected(poses.columns, rated)]
    lines += [
        f"  {WARNING} poses.csv: {clause}" for clause in misspelt_columns(list(poses.columns), len(joints))
    ]
    return lines + (_copies(poses, points) if points is not None and not still else [])


def _name_of_arm(robot: Mapping[str, Any]) -> list[str]:
    """Return a note if the table of joints is clearly not that of the library's arm whose name the robot bears."""
    doubt = doubt_of_name(Robot.from_mapping(robot))
    return [f"  note: {doubt}"] if doubt else []


def _without_motion(q: np.ndarray, points: Table | None, layout: MeasuredTable | None) -> list[str]:
    """Return a warning if all poses or all points are the same, or a note on single joints that never move."""
    xyz, items = np.empty((0, 1)), np.empty(0)
    if points is not None and layout is not None:
        xyz = np.column_stack([points.columns[name] for name in layout.units])
        items = np.zeros(len(xyz))
        if layout.item is not None and layout.item in points.columns:
            items = points.columns[layout.item].astype(str)
    file = "points.csv" if points is None else points.file
    if faults := faults_without_motion(q, xyz, items, file):
        return [f"  {WARNING} {fault}; `scalar calibrate` refuses them" for fault in faults]
    words = still_in_words(still_joints(q))
    return [f"  note: {words}; check that this was meant, and not left out of the record"] if words else []


def _beyond_limits(
    q: np.ndarray, ids: np.ndarray, joints: Sequence[Mapping[str, Any]], converted: str
) -> list[str]:
    """Return a warning for each joint that is beyond its stated limits in some poses; ``converted`` says how an import converted joints."""
    lines = []
    for i, joint in enumerate(joints):
        if "limits" not in joint:
            continue
        low, high = (float(limit) for limit in joint["limits"])
        excess = np.maximum(low - q[:, i], q[:, i] - high)
        count = int(np.count_nonzero(excess > _BEYOND))
        if not count:
            continue
        slides = joint.get("type") == "prismatic"
        unit, size = unit_of_joint(slides)
        worst = int(np.argmax(excess))
        check = "the limits in dataset.yaml, and the zero of this joint"
        if np.all((-q[:, i] > low - _BEYOND) & (-q[:, i] < high + _BEYOND)):
            check = "whether this joint counts the other way (with the other sign it stays within them), the limits in dataset.yaml, and its zero"
        turned = q[:, i] - 2.0 * np.pi * np.round((q[:, i] - 0.5 * (low + high)) / (2.0 * np.pi))
        if not slides and np.all((turned > low - _BEYOND) & (turned < high + _BEYOND)):
            check = "whether a whole turn was added when the angles were recorded, or the limits in dataset.yaml are too narrow"
        lines.append(
            f"  {WARNING} joint {i + 1} is beyond its limits {low / size:.1f} to {high / size:.1f} {unit} in {count} of {len(q)} poses, by at most "
            f"{excess[worst] / size:.1f} {unit} (pose {ids[worst]:.0f}); check {check}"
        )
    if lines and converted:
        lines.append(
            f"  note: these are the angles of the dataset, which are not those of the controller ({converted})"
        )
    return lines


def _small_angles(poses: Table, joints: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line if no joint turns by more than it would if radians had been read as degrees."""
    turning = [f"q{i + 1}" for i, joint in enumerate(joints) if joint.get("type") != "prismatic"]
    if poses.n_rows < _SEVERAL or not turning:
        return []
    largest = max(float(poses.columns[name].max() - poses.columns[name].min()) for name in turning)
    if largest > _TWO_TURNS_AS_DEGREES:
        return []
    return [
        f"  note: over all poses no joint turns by more than {largest / DEG:.2g} deg; were radians taken for degrees? poses.csv holds radians, and "
        "`unit` in a mapping is that of the file"
    ]


def _copies(poses: Table, points: Table) -> list[str]:
    """Return a line if poses repeat another one with its measurements to the last digit, which noise never does."""
    joints = [name for name in poses.columns if re.fullmatch(r"q[1-9][0-9]*", name)]
    alike: defaultdict[Any, list[Any]] = defaultdict(list)
    for pose, *q in zip(poses.columns["pose"], *(poses.columns[name] for name in joints), strict=True):
        alike[tuple(q)].append(pose)
    repeated = {pose for group in alike.values() if len(group) > 1 for pose in group}
    rows: defaultdict[Any, list[Any]] = defaultdict(list)
    measured = [points.columns[name] for name in points.columns if name != "pose"]
    for i, pose in enumerate(points.columns["pose"] if repeated else ()):
        if pose in repeated:
            rows[pose].append(tuple(column[i] for column in measured))
    copied = copies_in_words(
        (int(pose), (q, tuple(rows[pose]))) for q, group in alike.items() for pose in group if pose in rows
    )
    return [f"  note: {copied}; if one is a copy, remove it, since it counts twice"] if copied else []
