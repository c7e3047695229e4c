"""What may be wrong with a dataset: its description against the schema and against sense, and its tables.

Every check adds the faults it finds to a list and goes on, so that a user repairs a folder in one round. A check
whose premise another fault has taken away is left out, so that one mistake is not reported as ten. Whether the
numbers have the right units is asked in `scalar.suspicions`; whether they can determine a model, by the calibrator.
"""

import json
import re
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import pandas as pd
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from scalar.errors import Fault
from scalar.tables import Layout, Table, did_you_mean, shorten
from scalar.yaml_io import Lines, join_path

DESCRIPTION = "dataset.yaml"
MIN_PLANES = 3

_KINDS = {"number": "a number", "array": "a list", "object": "a mapping", "string": "text"}
_JOINT_COLUMN = re.compile(r"(q|approach)([0-9]+)")

Path = tuple[str | int, ...]


class Description:
    """The content of dataset.yaml while it is being checked: parts of it may be missing or malformed.

    Args:
        mapping: the plain data of the file.
        lines: the line of every value.
    """

    def __init__(self, mapping: Any, lines: Lines) -> None:
        self.mapping = mapping
        self.lines = lines
        self.faults: list[Fault] = []

    def get(self, *path: str | int) -> Any:
        """Return the value at `path`, or None if there is none."""
        value = self.mapping
        for key in path:
            if isinstance(value, dict) and isinstance(key, str):
                value = value.get(key)
            elif isinstance(value, list) and isinstance(key, int) and key < len(value):
                value = value[key]
            else:
                return None
        return value

    def items(self, *path: str | int) -> list[Any]:
        """Return the list at `path`, empty if there is none."""
        value = self.get(*path)
        return value if isinstance(value, list) else []

    def number(self, *path: str | int) -> float | None:
        """Return the finite number at `path`, or None."""
        value = self.get(*path)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
            return None
        return float(value)

    def vector(self, *path: str | int, size: int = 3) -> np.ndarray | None:
        """Return the finite numbers at `path` as ``(size,)``, or None."""
        numbers = [self.number(*path, i) for i in range(len(self.items(*path)))]
        return np.array(numbers, dtype=float) if len(numbers) == size and None not in numbers else None

    def fault(self, path: Path, message: str) -> None:
        """Add a fault at `path`, with the line of the nearest key that is there."""
        there = path
        while there and there not in self.lines:
            there = there[:-1]
        self.faults.append(Fault(DESCRIPTION, message, self.lines.get(there), join_path(path) or None))

    @property
    def kind(self) -> str | None:
        """Return the kind of the sensor, or None if it is not one of those known."""
        kind = self.get("sensor", "kind")
        return kind if kind in ("line-laser", "probe", "tracker") else None

    @property
    def n_joints(self) -> int:
        """Return the number of joints, 0 if they are not a list."""
        return len(self.items("robot", "joints"))

    @property
    def plane_names(self) -> list[str]:
        """Return the names of the planes."""
        planes = self.items("planes")
        return [p["name"] for p in planes if isinstance(p, dict) and isinstance(p.get("name"), str)]


@cache
def _validator() -> Draft202012Validator:
    text = resources.files("scalar").joinpath("schemas/dataset.schema.json").read_text(encoding="utf-8")
    return Draft202012Validator(json.loads(text))


def check_description(description: Description) -> None:
    """Add the faults of dataset.yaml to ``description.faults``."""
    if not isinstance(description.mapping, dict):
        description.fault((), "not a mapping; write keys and values, beginning with format: scalar-dataset/1")
        return
    errors = sorted(_validator().iter_errors(description.mapping), key=lambda e: [str(k) for k in e.absolute_path])
    for error in errors:
        _say(description, error)
    _check_finite(description, description.mapping, ())
    _check_robot(description)
    _check_sensor_and_planes(description)


def _say(description: Description, error: ValidationError) -> None:
    """Add what a schema error means, in words for the one who wrote the file."""
    path: Path = tuple(error.absolute_path)
    value: Any = error.instance
    expected: Any = error.validator_value
    meaning = error.schema.get("description", "") if isinstance(error.schema, dict) else ""
    match error.validator:
        case "additionalProperties":
            known = list(error.schema["properties"])  # pyright: ignore[reportArgumentType, reportIndexIssue]
            for key in (key for key in value if key not in known):
                hint = did_you_mean(key, [k for k in known if k not in value])
                description.fault((*path, key), f"unknown key; {hint}the keys here are {', '.join(known)}")
        case "required":
            for key in (key for key in expected if key not in value and f"{key!r} is a required" in error.message):
                sub = error.schema.get("properties", {}).get(key, {})  # pyright: ignore[reportAttributeAccessIssue]
                description.fault((*path, key), f"missing; add it: {sub.get('description', key)}")
        case "type":
            kinds = [expected] if isinstance(expected, str) else expected
            found = "empty" if value is None else f"not {_KINDS.get(kinds[0], kinds[0])} ({shorten(value)})"
            description.fault(path, f"{found}; write {meaning}")
        case "enum":
            hint = did_you_mean(str(value), list(expected))
            description.fault(path, f"unknown ({shorten(value)}); {hint}write one of {', '.join(expected)}")
        case "const":
            description.fault(path, f"{shorten(value)} cannot be read by this version; write {expected}")
        case "exclusiveMinimum":
            description.fault(path, f"{value} is not greater than {expected}; write {meaning}")
        case "minItems" | "maxItems":
            description.fault(path, f"{len(value)} entries where {expected} are needed; write {meaning}")
        case _:
            description.fault(path, f"empty; write {meaning}")


def _check_finite(description: Description, value: Any, path: Path) -> None:
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            _check_finite(description, item, (*path, key))
    elif isinstance(value, float) and not np.isfinite(value):
        description.fault(path, f"not a finite number ({value}); write the number")
    elif isinstance(value, int) and abs(value) > 1e300:
        description.fault(path, f"too large a number ({shorten(value, 20)}); correct it")


def _check_robot(description: Description) -> None:
    standard = description.get("robot", "convention") == "standard-dh"
    for i, joint in enumerate(description.items("robot", "joints")):
        path: Path = ("robot", "joints", i)
        if not isinstance(joint, dict):
            continue
        if joint.get("type") == "prismatic":
            message = "prismatic joints are reserved and not supported yet; describe a chain of revolute joints only"
            description.fault((*path, "type"), message)
        if standard and description.number(*path, "beta"):
            message = "beta belongs to modified DH; remove it, or write the chain as convention: modified-dh"
            description.fault((*path, "beta"), message)
        limits = description.vector(*path, "limits", size=2)
        if limits is not None and not limits[0] < limits[1]:
            message = f"the lowest angle ({limits[0]:g}) is not below the highest ({limits[1]:g}); exchange or correct them"
            description.fault((*path, "limits"), message)


def _check_sensor_and_planes(description: Description) -> None:
    kind = description.kind
    if kind in ("probe", "tracker") and description.get("sensor", "nominal_pose") is None:
        message = f"missing; a {kind} needs a rough {{translation: [x, y, z], rotation_vector: [0, 0, 0]}} [m, rad]"
        description.fault(("sensor", "nominal_pose"), message)
    names: dict[str, int] = {}
    for i, plane in enumerate(description.items("planes")):
        if not isinstance(plane, dict):
            continue
        name = plane.get("name")
        if isinstance(name, str):
            if name in names:
                message = f"{name!r} is the name of planes[{names[name]}] already; give each plane a name of its own"
                description.fault(("planes", i, "name"), message)
            elif name != name.strip():
                description.fault(("planes", i, "name"), f"blanks around the name ({name!r}); remove them")
            names.setdefault(name, i)
        normal = description.vector("planes", i, "normal")
        if normal is not None and not np.linalg.norm(normal) > 1e-6:
            description.fault(("planes", i, "normal"), "a normal of no length; write its direction, as in [0, 0, 1]")
    n_planes = len(description.items("planes"))
    if kind in ("line-laser", "probe") and n_planes < MIN_PLANES and isinstance(description.get("planes"), list | None):
        message = f"{n_planes} planes; a {kind} needs at least three, of different directions: add rough guesses"
        description.fault(("planes",), message)


def poses_layout(description: Description) -> Layout:
    """Return the columns of poses.csv that this description asks for."""
    n = description.n_joints
    joints = tuple(f"q{i + 1}" for i in range(n))
    plane = ("plane",) if description.kind in ("line-laser", "probe") else ()

    def refuse(name: str) -> str | None:
        match = _JOINT_COLUMN.fullmatch(name)
        if not match or not n or 1 <= int(match[2][:9]) <= n and str(int(match[2])) == match[2]:
            return None
        return f"the robot has {n} joints, counted from 1; remove the column, or complete robot.joints in {DESCRIPTION}"

    approach = tuple(f"approach{i + 1}" for i in range(n))
    return Layout(
        required=("pose", *plane, *joints),
        optional=("order", "time", "temperature", "session", *approach, *(() if plane else ("plane",))),
        text=frozenset({"plane", "session"}),
        extras=True,
        refuse=refuse,
    )


def check_poses(poses: Table, description: Description, faults: list[Fault]) -> None:
    """Add what is wrong with the contents of poses.csv, units aside."""
    if poses.whole and poses.n_rows == 0:
        faults.append(Fault(poses.file, "there is no pose; write a row a pose"))
    _check_unique(poses, "pose", "pose", faults)
    _check_unique(poses, "order", "order", faults)
    approach = [f"approach{i + 1}" for i in range(description.n_joints)]
    present = [name for name in approach if name in poses.columns]
    for name in present:
        values = poses.columns[name]
        wrong = ~np.isin(values, (-1.0, 1.0))
        poses.report(faults, name, wrong, lambda i, v=values: f"neither -1 nor 1 ({v[i]:g}); write the sign of the arrival")
    for name in approach if present else ():
        if name not in poses.columns:
            message = "the column is missing; the approach columns come for all joints or for none"
            faults.append(Fault(poses.file, message, 1, name))
    if description.kind in ("line-laser", "probe") and description.plane_names:
        _check_plane_names(poses, description, faults)


def _check_unique(table: Table, column: str, what: str, faults: list[Fault]) -> None:
    if column not in table.columns:
        return
    values = pd.Series(table.columns[column])
    repeated = values.duplicated().to_numpy() & ~values.isna().to_numpy()
    if not repeated.any():
        return
    lines = table.line_numbers()
    first = values.groupby(values).transform(lambda rows: rows.index[0]) if repeated.any() else values

    def message(i: int) -> str:
        row = lines[int(first.iloc[i])]
        return f"{what} {values.iloc[i]:.15g} stands already in row {row}; give each row its own, or remove one"

    table.report(faults, column, repeated, message)


def _check_plane_names(poses: Table, description: Description, faults: list[Fault]) -> None:
    if "plane" not in poses.columns:
        return
    names = description.plane_names
    found = poses.columns["plane"]
    unknown = ~np.isin(found.astype(str), names)

    def message(i: int) -> str:
        hint = did_you_mean(str(found[i]), names)
        return f"unknown plane {shorten(found[i])}; {hint}{DESCRIPTION} names {', '.join(names)}"

    poses.report(faults, "plane", unknown, message)
    used = [name for name in names if name in set(found)]
    if poses.good("plane") and poses.whole and poses.n_rows and len(set(names)) >= MIN_PLANES > len(used):
        unused = ", ".join(name for name in names if name not in used)
        text = f"poses of {len(used)} planes only, none of {unused}; at least three planes need poses: measure the others"
        faults.append(Fault(poses.file, text, column="plane"))


def check_points(points: Table, poses: Table | None, kind: str, faults: list[Fault]) -> None:
    """Add the points of unknown poses, and the poses without a point or (tracker) with more than one."""
    if points.whole and points.n_rows == 0:
        faults.append(Fault(points.file, "there is no point; write a row a point"))
        return
    if kind == "tracker":
        _check_unique(points, "pose", "pose", faults)
    if poses is None or "pose" not in poses.columns or "pose" not in points.columns:
        return
    known, ids = poses.columns["pose"], points.columns["pose"]
    if poses.whole and not np.isnan(known).any():
        values, first, counts = np.unique(ids, return_index=True, return_counts=True)
        strange = ~np.isin(values, known) & ~np.isnan(values)
        count_of = dict(zip(first[strange].tolist(), counts[strange].tolist(), strict=True))
        mask = np.zeros(points.n_rows, dtype=bool)
        mask[first[strange]] = True

        def strange_message(i: int) -> str:
            return f"unknown pose {ids[i]:.15g} ({count_of[i]} rows); remove them, or add the pose to {poses.file}"

        points.report(faults, "pose", mask, strange_message)
    if points.whole and not np.isnan(ids).any():
        what = "no laser point" if kind == "line-laser" else "no row"
        missing = ~np.isin(known, ids) & ~np.isnan(known)

        def missing_message(i: int) -> str:
            return f"pose {known[i]:.15g} has {what} in {points.file}; add it there, or remove this pose"

        poses.report(faults, "pose", missing, missing_message)


def unknown_data_files(kind: str, names: Sequence[str]) -> list[Fault]:
    """Return a fault for every data file that a sensor of this kind does not have."""
    belongs = {"line-laser": "scans", "tracker": "points"}.get(kind)
    owner = {"scans": "line-laser", "points": "tracker"}
    return [
        Fault(name, f"a {kind} has no such file; remove it, or set sensor.kind: {owner[stem]} in {DESCRIPTION}")
        for name in names
        for stem in owner
        if stem != belongs and name in (f"{stem}.csv", f"{stem}.parquet")
    ]
