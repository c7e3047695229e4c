"""Read a mapping file, and check all of it before a table is opened.

Keys are checked against the schema, columns and units against the sensor and the number of joints. Every column of lengths or angles
has to name its unit; none is guessed.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from importlib import resources
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from scalar.data.description import Description, check_description, check_finite, check_schema
from scalar.data.formats import DATASET_FORMAT
from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.data.io.regular_file import path_inside
from scalar.data.strict_schema import strict_validator
from scalar.data.unit_suspicions import suspect_description, write_si
from scalar.errors import Fault, InvalidInput
from scalar.ingest.mapping import MappingFile
from scalar.ingest.mapping_blocks import read_mapping_block
from scalar.ingest.mapping_columns import check_columns
from scalar.ingest.named_units import description_to_si, units_of_dataset

_UNITS_PLACE = "stands at the top of the mapping, on the level of dataset; move it there"
_TEXT_PLACE = "stands at the top of the mapping, where it applies to all files; points and nests may have a key text of their own in addition"
_OF_A_FILE = "remove this key, or write the content of that file under dataset"


@cache
def _validator() -> Draft202012Validator:
    """Return the validator of mappings."""
    text = (
        resources.files("scalar.ingest").joinpath("schemas/mapping.schema.json").read_text(encoding="utf-8")
    )
    return strict_validator(json.loads(text))


def load_mapping(
    path: Path, robot: Mapping[str, Any] | None = None, *, otherwise: Mapping[str, Any] | None = None
) -> MappingFile:
    """Return the mapping in a YAML file.

    Args:
        path: the mapping file.
        robot: the ``robot:`` block of the dataset in SI; None if the mapping states it. One of the two has to.
        otherwise: the ``robot:`` block that is taken if the mapping states none; unlike ``robot``, it may be given where the mapping states one.

    Raises:
        InvalidInput: with every fault of the keys; if there is none, with every fault of the dataset's description and of the columns.
    """
    content, lines = load_yaml_lines(path)
    given = Description(content, lines, path.name)
    if not isinstance(content, dict):
        raise InvalidInput(
            Fault(path.name, "not a mapping; write keys and values, beginning with format: scalar-mapping/1")
        )
    check_schema(given, _validator())
    check_finite(given, {key: value for key, value in content.items() if key != "dataset"}, ())
    given.faults = [_with_place_of_text(fault) for fault in given.faults]
    inner = content.get("dataset")
    if isinstance(inner, dict) and "dataset_units" in inner:
        given.fault(("dataset", "dataset_units"), _UNITS_PLACE)
    elif isinstance(inner, str) and "dataset_units" in content:
        given.fault(("dataset_units",), f"{inner} is a file, which is in metres and radians; {_OF_A_FILE}")
    if given.faults:
        raise InvalidInput(given.faults)
    description = _description(given, path, robot, otherwise)
    poses, points, nests = content["poses"], content.get("points"), content.get("nests")
    table = None if description.sensor_format is None else description.sensor_format.table
    references = None if description.sensor_format is None else description.sensor_format.references
    mapping = MappingFile(
        description,
        content.get("text", {}),
        content.get("matrix", {}).get("variable"),
        read_mapping_block(given, "poses", poses, table, description),
        None if points is None else read_mapping_block(given, "points", points, table, description),
        None if nests is None else read_mapping_block(given, "nests", nests, references, description),
    )
    if not description.faults:
        check_columns(given, mapping)
    for_all_files = content.get("text", {})
    for place, own in ((), {}), (("points",), points or {}), (("nests",), nests or {}):
        text = {**for_all_files, **own.get("text", {})}
        if "separator" not in text and text.get("decimal") == "," and (not place or "text" in own):
            message = "a comma is the separator already; set text.separator as well, e.g. ';', or ',' where the numbers stand in quotes"
            given.fault((*place, "text", "decimal"), message)
        if text.get("thousands") == text.get("decimal", ".") and (not place or "text" in own):
            message = f"'{text['thousands']}' is the decimal sign already; set text.decimal as well, e.g. ','"
            given.fault((*place, "text", "thousands"), message)
    if given.faults or description.faults:
        raise InvalidInput([*description.faults, *given.faults])
    return mapping


def _with_place_of_text(fault: Fault) -> Fault:
    """Return the fault; if its place is the key ``text`` in ``poses``, which is unknown there, with a message that says where this key belongs."""
    return replace(fault, message=_TEXT_PLACE) if fault.column == "poses.text" else fault


def _description(
    given: Description, path: Path, robot: Mapping[str, Any] | None, otherwise: Mapping[str, Any] | None
) -> Description:
    """Return the description of the dataset to be written; its faults name the file and the key that have to be corrected."""
    inner, inline = given.mapping["dataset"], True
    units = given.mapping.get("dataset_units", {})
    lines = {key[1:]: line for key, line in given.lines.items() if key[:1] == ("dataset",)}
    file = path.name
    if isinstance(inner, str):
        inline, other = False, path_inside(path.parent, inner, path.name, "dataset")
        inner, lines = load_yaml_lines(other)
        file = other.name
    wrong: list[tuple[tuple[str | int, ...], str]] = []
    if robot is None and isinstance(inner, dict) and "robot" not in inner:
        robot = otherwise
    if inline:
        inner.setdefault("format", DATASET_FORMAT)
        inner = {"format": inner["format"], **inner}
        inner, wrong = description_to_si(inner, units.get("length", "m"), units.get("angle", "rad"))
    if robot is not None and isinstance(inner, dict):  # anything else is a fault of the description
        if "robot" in inner:
            wrong.append(
                (("robot",), "another robot is given by --urdf; remove this key, or leave out --urdf")
            )
        else:
            inner = {**inner, "robot": robot}
    description = Description(inner, lines, file)
    for place, message in wrong:
        description.fault(place, message)
    check_description(description)
    suspect_description(description, partial(units_of_dataset, units) if inline else write_si)
    if inline:
        description.faults = [
            replace(f, column=f"dataset.{f.column}" if f.column else "dataset") for f in description.faults
        ]
    return description
