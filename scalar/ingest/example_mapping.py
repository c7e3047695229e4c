"""A mapping to begin with, for the robot and the sensor of a dataset folder: tables in degrees and millimetres, to be adapted by the user."""

from __future__ import annotations

import json
import re
from pathlib import Path

from scalar.data.description import DESCRIPTION, Description
from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.errors import Fault, InvalidInput

_OF_TWO = re.compile(r"q(\d+) = J(\d+) ([+-]) J(\d+)")
"""A joint whose angle in the dataset is a sum or difference of two that the controller shows, as the library states it."""
_KEYS = {"+": "plus", "-": "minus"}
_IN_TABLES = {"m": "mm", "rad": "deg"}  # how other programs usually write what the dataset has in this unit


def example_mapping(folder: Path) -> str:
    """Return the text of a mapping whose tables hold the joints and the measurements of a dataset folder, in degrees and millimetres.

    Args:
        folder: A folder with dataset.yaml, as ``scalar init`` writes it; its tables may be empty, and guesses of planes missing.

    Raises:
        InvalidInput: There is no dataset.yaml, or it names no joints or no known kind of sensor.
    """
    path = folder / DESCRIPTION
    if not path.is_file():
        message = f"there is no {DESCRIPTION}; give a folder as `scalar init` writes it"
        raise InvalidInput(Fault(str(folder), message))
    description = Description(*load_yaml_lines(path))
    if description.sensor_format is None or not description.n_joints:
        message = (
            f"it names no joints, or no known kind of sensor; `scalar validate {folder}` says what is missing"
        )
        raise InvalidInput(Fault(str(path), message))
    table = description.sensor_format.table
    files = ["  files: [{name: robot.csv}]"] if table is not None else []
    sources = "robot.csv" + (f" {table.stem}.csv" if table is not None else "")
    lines = [
        f"# A mapping for {folder.name}: put in the names of your files and columns. Keep it beside the folder {folder.name}.",
        "# `scalar import --keys` explains every key, and docs/mapping.md has other forms of tables. Then:",
        f"# scalar import THIS.yaml {sources} -o measured",
        "format: scalar-mapping/1",
        'text: {separator: ",", decimal: "."}  # of many European spreadsheets: {separator: ";", decimal: ","}',
        "poses:",
        *files,
        "  rows_in_order: true  # the rows are in the order in which they were measured; remove this line if they are not",
        "  columns:",
        "    pose: {column: pose}",
        *_plane(description),
        *_joints(description),
        "    # time: {column: time}  # likewise session (another value from where anything was set up anew), temperature, approach1 and so on",
    ]
    if table is not None:
        lines += [
            "points:",
            f"  files: [{{name: {table.stem}.csv}}]",
            "  columns:",
            "    pose: {column: pose}",
        ]
        if table.item is not None:
            lines.append(f"    # {table.item}: {{column: {table.item}}}  # where there are several")
        lines += [
            f"    {name}: {{column: {name}, unit: {_IN_TABLES[unit]}}}" for name, unit in table.units.items()
        ]
    if table is not None and "rx" in table.optional:
        lines.append(
            "    # whole poses: qw: {column: qw}, likewise qx, qy, qz; or Euler angles e1, e2, e3, with euler_axes (docs/mapping.md)"
        )
    lines.append(f"dataset: {json.dumps(f'{folder.name}/{DESCRIPTION}', ensure_ascii=False)}")
    return "\n".join(lines)


def _plane(description: Description) -> list[str]:
    """Return the line on the plane that a pose measures, where the kind of sensor has planes."""
    if description.sensor_format is None or not description.sensor_format.on_planes:
        return []
    named = f" ({', '.join(description.plane_names)})" if description.plane_names else ""
    return [f"    plane: {{column: plane}}  # the names as in {DESCRIPTION}{named}"]


def _joints(description: Description) -> list[str]:
    """Return a line for each joint, in which a joint that the maker's controller is known to count otherwise is converted."""
    from scalar.robots.library import resembling

    arm = next(iter(resembling(str(description.get("robot", "name") or ""))), None)
    called = [f"J{i + 1}" for i in range(description.n_joints)]
    if arm is not None and len(arm.axis_names) == len(called):
        called = list(arm.axis_names)
    of_two = _OF_TWO.fullmatch(arm.controller_joints) if arm is not None else None
    lines = []
    for i, column in enumerate(called):
        unit = _IN_TABLES["m" if description.slides(i) else "rad"]
        rest, why = "", ""
        if arm is not None and of_two is not None and int(of_two[1]) == i + 1:
            rest = f", {_KEYS[of_two[3]]}: {json.dumps(called[int(of_two[4]) - 1])}"
            why = f"  # {arm.maker}'s controller shows J{of_two[2]} so: {of_two[0]}"
        lines.append(f"    q{i + 1}: {{column: {json.dumps(column)}, unit: {unit}{rest}}}{why}")
    return lines
