"""The content of dataset.yaml, checked against its schema and for contradictions.

Each schema error becomes one line that the author of the file understands. `scalar.data.unit_suspicions` checks
whether the numbers have the right units.
"""

import json
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator

from scalar.data.formats import DATASET_FORMAT, FEW_PLANES
from scalar.data.io.plain_yaml import LARGEST, Lines, join_path
from scalar.data.located_table import shorten
from scalar.data.schema_words import KeyPath, in_plain_words
from scalar.data.sensor_formats import SensorFormat, sensor_formats
from scalar.data.strict_schema import strict_validator
from scalar.errors import Fault

DESCRIPTION = "dataset.yaml"
MIN_PLANES = 3  # space has three dimensions
NO_MORE_PLANES = (
    f"; if you have no more planes, add the line {FEW_PLANES}: true to {DESCRIPTION}: what these do not show is then left "
    "to the data sheet"
)
"""The end of every message that refuses planes because they are too few or span too little."""
_OFF_PLANE = 0.2  # m; a guess of a plane may err by 10 cm, and by 30 degrees, which is 10 cm at 20 cm from where the guess is right
MAX_JOINTS = 100
"""The schema's limit. A longer chain is a fault, and the tables are then not checked for its joints' columns."""


def least_planes(few_planes: object) -> int:
    """Return how many planes a sensor needs that measures planes: three, or one if ``few_planes`` of dataset.yaml says that there are no more."""
    return 1 if few_planes is True else MIN_PLANES


class Description:
    """The content of dataset.yaml while it is being checked: parts of it may be missing or malformed.

    Args:
        mapping: the plain data of the file.
        lines: the line of every value.
        file: the name of the file, in messages.
    """

    def __init__(self, mapping: Any, lines: Lines, file: str = DESCRIPTION) -> None:
        self.mapping = mapping
        self.lines = lines
        self.file = file
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
        """Return the number at `path`, or None if there is none or its size is above ``LARGEST``."""
        value = self.get(*path)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
            return None
        return float(value)

    def vector(self, *path: str | int, size: int = 3) -> np.ndarray | None:
        """Return the list at `path` as ``(size,)``; None unless it is exactly `size` finite numbers."""
        numbers = [self.number(*path, i) for i in range(len(self.items(*path)))]
        return np.array(numbers, dtype=float) if len(numbers) == size and None not in numbers else None

    def fault(self, path: KeyPath, message: str) -> None:
        """Add a fault at `path`, with the line of the innermost key on the path that exists."""
        there = path
        while there and there not in self.lines:
            there = there[:-1]
        self.faults.append(Fault(self.file, message, self.lines.get(there), join_path(path) or None))

    @property
    def is_version_2(self) -> bool:
        """Return whether the file declares version 2 of the dataset's format, the one that is written."""
        return self.get("format") == DATASET_FORMAT

    @property
    def kind(self) -> str | None:
        """Return the kind of the sensor, or None if it is not one of those known."""
        kind = self.get("sensor", "kind")
        return kind if isinstance(kind, str) and kind in sensor_formats() else None

    @property
    def sensor_format(self) -> SensorFormat | None:
        """Return what the folder of a sensor of this kind holds, or None if the kind is not one of those known."""
        return None if self.kind is None else sensor_formats()[self.kind]

    @property
    def n_joints(self) -> int:
        """Return the number of joints, 0 if they are not a list or are too many."""
        n = len(self.items("robot", "joints"))
        return n if n <= MAX_JOINTS else 0

    def slides(self, joint: int) -> bool:
        """Return whether a joint, from 0, is prismatic."""
        return self.get("robot", "joints", joint, "type") == "prismatic"

    @property
    def least_planes(self) -> int:
        """Return how many planes a sensor needs that measures planes: three, or one if there are said to be no more."""
        return least_planes(self.get(FEW_PLANES))

    @property
    def plane_names(self) -> list[str]:
        """Return the names of the planes."""
        planes = self.items("planes")
        return [p["name"] for p in planes if isinstance(p, dict) and isinstance(p.get("name"), str)]


@cache
def _schema_text() -> str:
    return resources.files("scalar.data").joinpath("schemas/dataset.schema.json").read_text(encoding="utf-8")


def _validator(format: SensorFormat | None) -> Draft202012Validator:
    """Return the validator of dataset.yaml for a sensor of this format: it allows all registered kinds, and this format's options."""
    schema = json.loads(_schema_text())
    sensor = schema["properties"]["sensor"]["properties"]
    sensor["kind"]["enum"] = list(sensor_formats())
    del sensor["kind"]["type"]
    sensor |= {} if format is None else dict(format.options)
    return strict_validator(schema)


def check_description(description: Description) -> None:
    """Add the faults of dataset.yaml to ``description.faults``."""
    if not isinstance(description.mapping, dict):
        description.fault(
            (), f"not a mapping; write keys and values, beginning with format: {DATASET_FORMAT}"
        )
        return
    check_schema(description, _validator(description.sensor_format))
    check_finite(description, description.mapping, ())
    _check_robot(description)
    _check_sensor_and_planes(description)


def check_schema(description: Description, validator: Draft202012Validator) -> None:
    """Add every difference from a schema to ``description.faults``."""
    errors = validator.iter_errors(description.mapping)
    for error in sorted(errors, key=lambda e: [str(k) for k in e.absolute_path]):
        for path, message in in_plain_words(error):
            description.fault(path, message)


def check_finite(description: Description, value: Any, path: KeyPath) -> None:
    """Add every number that is not finite, or too large to compute with, to ``description.faults``."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            check_finite(description, item, (*path, key))
    elif isinstance(value, float) and not np.isfinite(value):
        description.fault(path, f"not a finite number ({value}); write the number")
    elif isinstance(value, int | float) and abs(value) > LARGEST:
        description.fault(path, f"too large a number ({shorten(value, 20)}); correct it")


def _check_robot(description: Description) -> None:
    standard = description.get("robot", "convention") == "standard-dh"
    for i, joint in enumerate(description.items("robot", "joints")):
        path: KeyPath = ("robot", "joints", i)
        if not isinstance(joint, dict):
            continue
        if standard and description.number(*path, "beta"):
            message = "beta belongs to modified DH; remove it, or write the chain as convention: modified-dh"
            description.fault((*path, "beta"), message)
        limits = description.vector(*path, "limits", size=2)
        if limits is not None and not limits[0] < limits[1]:
            what = "travel" if description.slides(i) else "angle"
            remedy = "swap them" if limits[0] > limits[1] else "state the whole range of the joint"
            message = f"the lowest {what} ({limits[0]:g}) is not below the highest ({limits[1]:g}); {remedy}"
            description.fault((*path, "limits"), message)


def _check_sensor_and_planes(description: Description) -> None:
    kind, format = description.kind, description.sensor_format
    if format is not None and format.needs_nominal_pose and description.get("sensor", "nominal_pose") is None:
        message = (
            f"missing; a {kind} needs an initial guess of its pose on the flange: "
            "{translation: [x, y, z], rotation_vector: [rx, ry, rz]} [m, rad]"
        )
        description.fault(("sensor", "nominal_pose"), message)
    names: dict[str, int] = {}
    for i, plane in enumerate(description.items("planes")):
        if not isinstance(plane, dict):
            continue
        name = plane.get("name")
        if isinstance(name, str):
            if name in names:
                message = f"{name!r} is the name of planes[{names[name]}] already; rename one of the two"
                description.fault(("planes", i, "name"), message)
            elif name != name.strip():
                description.fault(("planes", i, "name"), f"blanks around the name ({name!r}); remove them")
            names.setdefault(name, i)
        normal = description.vector("planes", i, "normal")
        if normal is not None and not np.linalg.norm(normal) > 1e-6:
            description.fault(
                ("planes", i, "normal"), "a normal of no length; write its direction, as in [0, 0, 1]"
            )
        _check_extent(description, i, normal)
    n_planes = len(description.items("planes"))
    if (
        format is not None
        and format.on_planes
        and n_planes < description.least_planes
        and isinstance(description.get("planes"), list | None)
    ):
        message = (
            f"{n_planes} plane{'' if n_planes == 1 else 's'}; a {kind} needs at least three, of different directions: add an initial guess of each "
            f"to planes (a plate that is set up again elsewhere, under another name, counts as a further plane){NO_MORE_PLANES if n_planes else ''}"
        )
        description.fault(("planes",), message)


def _check_extent(description: Description, i: int, normal: np.ndarray | None) -> None:
    """Add a fault if the middle of a target plane does not lie on it."""
    centre, distance = (
        description.vector("planes", i, "extent", "centre"),
        description.number("planes", i, "distance"),
    )
    if centre is None or distance is None or normal is None or not np.linalg.norm(normal) > 1e-6:
        return
    off = abs(float(normal @ centre) - distance) / float(np.linalg.norm(normal))
    if off > _OFF_PLANE:
        message = f"the centre lies {off:.3g} m from the plane that normal and distance describe; correct one of the three [m, base frame]"
        description.fault(("planes", i, "extent", "centre"), message)
