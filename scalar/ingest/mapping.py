"""A mapping file: which column of a foreign table becomes which of ours, in which unit, for which robot.

Everything is checked before a table is opened: keys against the schema, columns and units against the sensor
and the number of joints. A length or an angle has to name its unit; none is guessed.
"""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from scalar.data.description import Description, check_description, check_finite, check_schema
from scalar.data.folder import POINT_COLUMNS
from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.data.located_table import did_you_mean, shorten
from scalar.data.unit_suspicions import suspect_description
from scalar.errors import Fault, InvalidInput
from scalar.ingest.foreign_tables import Reference
from scalar.ingest.named_units import UNITS, description_to_si

_TEXT = ("plane", "session")
JOINT = re.compile(r"q[1-9][0-9]*")
_SI = {"length": "m", "angle": "rad"}


@dataclass(frozen=True)
class Column:
    """Where one of our columns comes from: ``ours = sign * theirs + offset``, in their unit, then in SI.

    Attributes:
        reference: the column of the file.
        to_si: from the file's unit to SI.
        sign: 1 or -1.
        offset: in the file's unit.
        names: for text: what the file's values are called here; None where they stay.
    """

    reference: Reference
    to_si: Callable[[Any], Any]
    sign: float = 1.0
    offset: float = 0.0
    names: Mapping[str, str] | None = None


@dataclass(frozen=True)
class FileRule:
    """A file, or files by a pattern, and what holds for all their rows.

    Attributes:
        name: of the file, or a pattern of names.
        text: plane and session, where they are the same in the whole file.
        covariates: numbers that are the same in the whole file.
        first_pose: the id of its first pose where ids are counted; None: they go on from the file before.
    """

    name: str
    text: Mapping[str, str]
    covariates: Mapping[str, float]
    first_pose: int | None = None


@dataclass(frozen=True)
class Block:
    """A table to be made: of poses or of points.

    Attributes:
        columns: by our name, covariates among them.
        files: empty where every file given is meant.
        drop_without: our columns without which a row is left out.
        first_of_each: the file's column that tells the poses apart where a pose has several rows.
    """

    columns: Mapping[str, Column]
    files: tuple[FileRule, ...]
    drop_without: tuple[str, ...]
    first_of_each: Reference | None


@dataclass(frozen=True)
class MappingFile:
    """A mapping without a fault.

    Attributes:
        description: the content of dataset.yaml to be, in SI, checked.
        text: how text files are written.
        variable: of a .mat file.
        poses: the table of poses.
        points: the table of points, where it is in files of its own.
    """

    description: Description
    text: Mapping[str, Any]
    variable: str | None
    poses: Block
    points: Block | None

    @property
    def point_columns(self) -> tuple[str, ...]:
        """Return the coordinates that the sensor needs: ``x, z``, ``x, y, z`` or none."""
        return POINT_COLUMNS.get(self.description.kind or "", ("pose",))[1:]


@cache
def _validator() -> Draft202012Validator:
    text = (
        resources.files("scalar.ingest").joinpath("schemas/mapping.schema.json").read_text(encoding="utf-8")
    )
    return Draft202012Validator(json.loads(text))


def load_mapping(path: Path) -> MappingFile:
    """Return the mapping in a YAML file.

    Raises:
        InvalidInput: with every fault found; a misspelt key, column or unit is named.
    """
    content, lines = load_yaml_lines(path)
    given = Description(content, lines, path.name)
    if not isinstance(content, dict):
        raise InvalidInput(
            Fault(path.name, "not a mapping; write keys and values, beginning with format: scalar-mapping/1")
        )
    check_schema(given, _validator())
    check_finite(given, {key: value for key, value in content.items() if key != "dataset"}, ())
    if given.faults:
        raise InvalidInput(given.faults)
    description = _description(given, path)
    poses, points = content["poses"], content.get("points")
    mapping = MappingFile(
        description,
        content.get("text", {}),
        content.get("matrix", {}).get("variable"),
        _block(given, "poses", poses),
        None if points is None else _block(given, "points", points),
    )
    if not description.faults:
        _check_columns(given, mapping)
    if given.get("text", "separator") in (None, ",") and given.get("text", "decimal") == ",":
        given.fault(
            ("text", "decimal"), "a comma is the separator already; set text.separator as well, e.g. ';'"
        )
    if given.faults or description.faults:
        raise InvalidInput([*description.faults, *given.faults])
    return mapping


def _description(given: Description, path: Path) -> Description:
    """Return the content of dataset.yaml to be; what is wrong is in its faults, named as in its file."""
    inner, inline = given.mapping["dataset"], True
    units = given.mapping.get("dataset_units", {})
    lines = {key[1:]: line for key, line in given.lines.items() if key[:1] == ("dataset",)}
    file = path.name
    if isinstance(inner, str):
        inline, other = False, path.parent / inner
        if units:
            given.fault(("dataset_units",), f"{inner} is in metres and radians already; remove this key")
        inner, lines = load_yaml_lines(other)
        file = other.name
    wrong: list[tuple[tuple[str | int, ...], str]] = []
    if inline:
        inner.setdefault("format", "scalar-dataset/1")
        inner = {"format": inner["format"], **inner}
        inner, wrong = description_to_si(inner, units.get("length", "m"), units.get("angle", "rad"))
    description = Description(inner, lines, file)
    for place, message in wrong:
        description.fault(place, message)
    check_description(description)
    suspect_description(description)
    if inline:
        description.faults = [
            replace(f, column=f"dataset.{f.column}" if f.column else "dataset") for f in description.faults
        ]
    return description


def _quantity(name: str) -> str | None:
    """Return the quantity in a column of ours that has a unit, or None."""
    if JOINT.fullmatch(name):
        return "angle"
    return {"x": "length", "y": "length", "z": "length", "time": "time", "temperature": "temperature"}.get(
        name
    )


def _block(given: Description, key: str, block: Mapping[str, Any]) -> Block:
    """Return a block of the mapping; its faults go to ``given.faults``."""
    columns: dict[str, Column] = {}
    for name, entry in block["columns"].items():
        columns[name] = _column(given, (key, "columns", name), name, entry, _quantity(name))
    for name, entry in block.get("covariates", {}).items():
        columns[name] = _column(given, (key, "covariates", name), name, entry, None)
    files = tuple(
        FileRule(
            rule["name"],
            {text: str(rule[text]) for text in _TEXT if text in rule},
            {name: float(value) for name, value in rule.get("covariates", {}).items()},
            rule.get("first_pose"),
        )
        for rule in block.get("files", [])
    )
    dropped = tuple(block.get("drop_without", []))
    for i, name in enumerate(dropped):
        if name not in columns:
            hint = did_you_mean(name, list(columns))
            given.fault(
                (key, "drop_without", i),
                f"no such column here ({shorten(name)}); {hint}write one of {', '.join(columns)}",
            )
    return Block(columns, files, dropped, block.get("first_of_each"))


def _column(
    given: Description, path: tuple[str | int, ...], name: str, entry: Mapping[str, Any], quantity: str | None
) -> Column:
    unit = entry.get("unit")
    units = UNITS.get(quantity or "", {})
    if quantity is None and unit is not None:
        message = f"{name} is kept as it is, without a unit; remove this key"
        given.fault((*path, "unit"), message)
    elif quantity in _SI and unit is None:
        given.fault((*path, "unit"), f"missing; add it: the unit in the file, {' or '.join(units)}")
    elif unit is not None and unit not in units:
        hint = did_you_mean(unit, list(units))
        given.fault((*path, "unit"), f"unknown ({shorten(unit)}); {hint}write one of {', '.join(units)}")
    for key in ("sign", "offset"):
        if key in entry and quantity != "angle":
            given.fault((*path, key), "only joints have one; remove this key")
    if "names" in entry and name not in _TEXT:
        given.fault((*path, "names"), "only plane and session have names; remove this key")
    to_si = units.get(unit or "", lambda value: value)
    offset, names = float(entry.get("offset", 0.0)), entry.get("names")
    return Column(entry["column"], to_si, float(entry.get("sign", 1)), offset, names)


def _check_columns(given: Description, mapping: MappingFile) -> None:
    """Add columns that are missing, misspelt, or belong to another robot or sensor to ``given.faults``."""
    n, sensor = mapping.description.n_joints, mapping.description.kind
    points, kinds = mapping.point_columns, sorted(POINT_COLUMNS)
    joints = [f"q{i + 1}" for i in range(n)]
    plane = ["plane"] if sensor != "tracker" else []
    optional = ["pose", "order", "time", "temperature", "session", *(f"approach{i + 1}" for i in range(n))]
    known = [*joints, *plane, *([] if mapping.points else points), *optional]
    set_by_file = (
        set.intersection(*({*rule.text} for rule in mapping.poses.files)) if mapping.poses.files else set()
    )
    required = [*joints, *(name for name in plane if name not in set_by_file)]
    if mapping.points is None:
        required += points
    elif not points:
        given.fault(
            ("points",), f"a {sensor} has no points of its own, only {', '.join(kinds)} have; remove this key"
        )
    else:
        _check_block(given, "points", ["pose", *points], ["pose", *points])
        required.append("pose")
        if not mapping.poses.files:
            given.fault(
                ("poses", "files"),
                "missing; add it: with points in files of their own, each block names its files",
            )
    several = sensor == "line-laser" and mapping.points is None
    if several and mapping.poses.first_of_each is None:
        given.fault(
            ("poses", "first_of_each"),
            "missing; add it: the column that tells the scans apart, a point being a row",
        )
    _check_block(given, "poses", required, known)
    own = {*known, *_TEXT, "x", "y", "z"}
    covariates = [(("poses", "covariates", name), name) for name in given.get("poses", "covariates") or {}]
    for i, rule in enumerate(mapping.poses.files):
        covariates += [(("poses", "files", i, "covariates", name), name) for name in rule.covariates]
        both = [name for name in (*rule.text, *rule.covariates) if name in mapping.poses.columns]
        for name in both:
            given.fault(("poses", "files", i), f"{name} comes from a column as well; keep one of the two")
        if rule.first_pose is not None and "pose" in mapping.poses.columns:
            given.fault(
                ("poses", "files", i, "first_pose"), "ids come from a column as well; keep one of the two"
            )
        if "plane" in rule.text and not plane:
            given.fault(("poses", "files", i, "plane"), "a tracker has no planes; remove this key")
    for path, name in covariates:
        if name in own or re.fullmatch(r"(q|approach)[0-9]+", name):
            given.fault(
                path, "not a covariate but a column of the format; put it under columns, or rename it"
            )
        elif name != name.strip() or not name or re.search(r"[\",\n\r]", name):
            given.fault(path, f"not a name for a column ({shorten(name)}); use letters, digits and _")


def _check_block(given: Description, key: str, required: list[str], known: list[str]) -> None:
    columns = given.get(key, "columns")
    for name in columns:
        if name not in known:
            hint = did_you_mean(name, [k for k in known if k not in columns])
            extra = "" if key == "points" else "; a column of your own goes under covariates"
            message = f"unknown column; {hint}the columns here are {', '.join(known)}{extra}"
            given.fault((key, "columns", name), message)
    for name in required:
        if name not in columns:
            message = "missing; add it, as {column: name in the file" + (
                ", unit: m}" if _quantity(name) == "length" else "}"
            )
            message = message.replace("}", ", unit: rad}") if _quantity(name) == "angle" else message
            given.fault((key, "columns", name), message)
