"""Write a dataset folder that the user fills in: dataset.yaml with comments, tables with their headers, and README.txt.

What only the user knows is left empty, so that `scalar validate` reports it as missing: guesses of the planes, the sensor's nominal
pose if the sensor needs one, and every row of the tables.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scalar.data.description import DESCRIPTION
from scalar.data.formats import DATASET_FORMAT
from scalar.data.io.atomic import atomic_directory
from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.errors import printable
from scalar.units import DEG, MM

README = "README.txt"
_POSES = "poses.csv"
_ROUNDING = 1e-11  # [m or rad]: a smaller length or angle is a rounding error
_REMEDY = "a dataset is begun in a new or an empty folder only; give another place"
# A number that differs by less than _LAST_BITS from one with so many decimals is that one: 0.3500000000000001 is 0.35.
_DECIMALS, _LAST_BITS = 12, 1e-14
_PROFILE = "z points from the scanner to what it measures, and x lies across, in the plane of the laser."
_PLANES = (
    "",
    "# Guesses of the planes in the base frame: normal . p = distance [m]. 30 degrees and 10 cm off is near enough.",
    "# Three planes or more, of different directions; if you have only one or two, add the line few_planes: true. `scalar plan` takes them to",
    "# have no end; where a plate is small, say which circle it covers: extent: {centre: [0.8, 0.2, 0.5], radius: 0.25} after its distance [m].",
    "# Take away the [] and the #, and put in your own:",
    "planes: []",
    "#  - {name: floor, normal: [0.0, 0.0, 1.0], distance: 0.0}",
    "#  - {name: wall_x, normal: [1.0, 0.0, 0.0], distance: 0.8}",
    "#  - {name: wall_y, normal: [0.0, 1.0, 0.0], distance: 0.8}",
)
"""The lines on planes."""


def write_blank_dataset(
    folder: Path,
    robot: Mapping[str, Any],
    format: SensorFormat,
    about_robot: Sequence[str] = (),
    remarks: Sequence[str] = (),
) -> None:
    """Write a dataset folder without measurements, whole or not at all.

    Args:
        folder: The folder to write; it must be missing or empty.
        robot: The ``robot:`` block of dataset.yaml.
        format: Format of a dataset with the wanted kind of sensor: its tables, columns and options.
        about_robot: Lines that are written as comments in the block ``robot:``; the first is the dataset's ``source`` as well.
        remarks: What a user of this arm should know; written as comments behind these lines, and in README.txt.

    Raises:
        InvalidInput: The folder holds something already, or cannot be written.
    """
    folder = Path(folder)
    n = len(robot["joints"])
    files = {
        DESCRIPTION: _description(
            Path(os.path.realpath(folder)).name, robot, format, [*about_robot, *remarks]
        ),
        _POSES: ",".join(_pose_columns(n, format)) + "\n",
        README: _readme(robot, format, remarks),
    }
    if format.table is not None:
        files[format.table.files[0]] = ",".join(format.table.columns) + "\n"
    with atomic_directory(folder, remedy=_REMEDY) as temporary:
        for name, text in files.items():
            (temporary / name).write_text(text, encoding="utf-8", newline="\n")


def _pose_columns(n: int, format: SensorFormat) -> list[str]:
    """Return the columns of poses.csv for an arm of n joints."""
    return ["pose", *(["plane"] if format.on_planes else []), *(f"q{i + 1}" for i in range(n))]


def _description(
    name: str, robot: Mapping[str, Any], format: SensorFormat, about_robot: Sequence[str]
) -> str:
    """Return the text of dataset.yaml."""
    lines = [
        "# What was measured, and on what. Lengths in metres, angles in radians; a line that begins with # is a comment.",
        "# README.txt says what belongs in the tables. `scalar validate` on this folder says what is still missing.",
        f"format: {DATASET_FORMAT}",
        f"name: {_quoted(name)}",
        f"source: {_quoted(about_robot[0] if about_robot else '')}  # free text: add who measured, when, with what",
        "",
        *_robot_block(robot, about_robot),
        "",
        *_sensor_block(format),
        *(_PLANES if format.on_planes else ()),
    ]
    return "\n".join(lines) + "\n"


def _robot_block(robot: Mapping[str, Any], about_robot: Sequence[str]) -> list[str]:
    """Return the lines of the block ``robot:``."""
    lines = [
        "robot:",
        *(f"  # {printable(line)}" for line in about_robot),
        f"  name: {_quoted(robot['name'])}",
        f"  convention: {robot['convention']}",
        "  joints:  # base to flange; the angle of joint i is q_i + theta, q_i as in poses.csv",
    ]
    for i, joint in enumerate(robot["joints"]):
        comment = f"  # joint {i + 1}"
        if "limits" in joint:
            size, unit = (MM, "mm") if joint.get("type") == "prismatic" else (DEG, "degrees")
            low, high = (limit / size for limit in joint["limits"])
            comment += f", {low:.4g} to {high:.4g} {unit}"
        lines.append(f"    - {_flow(joint)}{comment}")
    if not any("limits" in joint for joint in robot["joints"]):
        lines.append(
            "  # Add `limits: [-3.14, 3.14]` [rad; m where a joint slides] to each joint: `scalar plan` keeps to them. Without limits, it "
            "keeps to -pi to pi (-1 to 1 m where a joint slides)."
        )
    for key in ("base", "flange", "gravity", "tolerance"):
        if key in robot:
            lines.append(f"  {key}: {_flow(robot[key])}")
    if "gravity" not in robot:
        lines.append(
            "  # gravity: [0.0, 0.0, 9.81]  # [m/s^2] in the base frame, where the arm hangs from a ceiling or stands on a wall; it is "
            "[0, 0, -9.81] if not stated"
        )
    if "tolerance" not in robot:
        lines.append(
            "  # tolerance: {length: 3.0e-4, angle: 3.0e-4}  # of the maker's geometry, if stated: one standard deviation [m, rad]"
        )
    return lines


def _sensor_block(format: SensorFormat) -> list[str]:
    """Return the lines of the block ``sensor:``."""
    pose = (
        "nominal_pose: {translation: [0.0, 0.0, 0.1], rotation_vector: [0.0, 0.0, 0.0]}  # flange to sensor"
    )
    needed = (
        "needed: take away the #, and put in your own numbers"
        if format.needs_nominal_pose
        else "needed by `scalar plan` and `scalar import-bag`, not by `scalar calibrate`: take away the #, and put in your own numbers"
    )
    return [
        "sensor:",
        f"  kind: {format.kind}",
        f"  # {pose} [m, rad], rough; {needed}",
        "  # noise: 1.0e-4  # one standard deviation of a measurement [m]; if it is left out, it is estimated",
        *(f"  # {key}: {spec.get('description', 'see the help')}" for key, spec in format.options.items()),
    ]


def _quoted(text: str) -> str:
    """Return text in quotes for YAML; characters that cannot be printed become escapes."""
    return json.dumps(printable(text), ensure_ascii=False)


def _flow(value: Any) -> str:
    """Return plain data as YAML in one line, numbers without rounding errors."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, str):
        return _quoted(value)
    number = 0.0 if abs(value) < _ROUNDING else float(value)
    if abs(number - round(number, _DECIMALS)) < _LAST_BITS:
        number = round(number, _DECIMALS)
    mantissa, e, exponent = repr(number).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + e + exponent


def _readme(robot: Mapping[str, Any], format: SensorFormat, remarks: Sequence[str]) -> str:
    """Return the text of README.txt: what belongs in which file, with an example row of each table."""
    n = len(robot["joints"])
    sliding = [f"q{i + 1}" for i, joint in enumerate(robot["joints"]) if joint.get("type") == "prismatic"]
    travels = f"; {', '.join(sliding)}: the travel in metres" if sliding else ""
    angles = [f"{0.1 * (-1) ** i * (i + 1):.4f}" for i in range(n)]
    example = ["0", *(["floor"] if format.on_planes else []), *angles]
    lines = [
        "This folder is a dataset of SCALAR, ready to be filled. `scalar validate` says what is still missing.",
        "",
        f"{DESCRIPTION}: the robot, the sensor"
        + (", and a guess of each plane." if format.on_planes else "."),
        "Its comments say what to fill in.",
        "",
        f"{_POSES}: a row for each pose [joint angles in radians{travels}], with the signs and zeros of the controller. An example row:",
        "  " + ",".join(_pose_columns(n, format)),
        "  " + ",".join(example),
        *(f"Of this arm: {printable(remark)}" for remark in remarks),
        "pose is a whole number of your choice"
        + (", plane a name from dataset.yaml." if format.on_planes else "."),
        "Optional columns, used where present: order (of acquisition; without it, that of the rows is assumed), time [s], temperature [deg C],",
        "session (after the planes, the tracker or the sensor were set up again), approach1, approach2, ... (1 if a joint arrived with",
        "a growing position, -1 if with a falling one). 60 to 100 poses, spread over the workspace, are a usual number.",
        "",
    ]
    table = format.table
    if table is None:
        lines += [
            "There is no third file: a contact with a plane is described by the joint angles and the plane's name.",
        ]
    else:
        units = ", ".join(f"{column} [{unit}]" for column, unit in table.units.items())
        values = [
            f"{0.01 * (i + 1) if table.several_rows else 0.5 * (i + 1):.5f}" for i in range(len(table.units))
        ]
        rows = (
            f"one row or more for each pose, a row for each {table.row}"
            if table.several_rows
            else "one row for each pose"
        )
        lines += [
            f"{table.files[0]}: {rows}; pose as in {_POSES}, {units}. An example row:",
            "  " + ",".join(table.columns),
            "  " + ",".join(["0", *values]),
            *([_PROFILE] if format.scans and set(table.units) == {"x", "z"} else []),
            *_further(table),
            *_references(format.references),
        ]
    lines += [
        "",
        "Your tables are in degrees and millimetres, or have other columns? Leave the tables here empty, and write a mapping, with which",
        "`scalar import` makes another folder from yours. `scalar import --example FOLDER` prints a mapping to begin with (FOLDER is this one).",
    ]
    lines += ["", "Then: scalar calibrate FOLDER -o OUT, and scalar diagnose FOLDER -o OUT."]
    return "\n".join(lines) + "\n"


def _further(table: MeasuredTable) -> list[str]:
    """Return the lines of README.txt about the optional columns of a table."""
    if not table.further:
        return []
    columns = [
        f"{name} [{table.optional[name]}]" if name in table.optional else name for name in table.further
    ]
    several = (
        [
            f"If several {table.item}s are measured, each has a row of its own, and the column {table.item} names it.",
            f"nominal_pose in {DESCRIPTION} is that of the first {table.item} of the file; where the others sit need not be known.",
        ]
        if table.item is not None
        else []
    )
    return [f"Optional columns: {', '.join(columns)}.", *several]


def _references(table: MeasuredTable | None) -> list[str]:
    """Return the line of README.txt about points fixed to the base."""
    if table is None:
        return []
    columns = ",".join(("pose", str(table.item), *table.units))
    return [
        f"Optional: {table.files[0]}, {columns}: points fixed to the robot's base, measured at the same poses. They show what moves besides the arm."
    ]
