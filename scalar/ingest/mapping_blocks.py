"""Read one block of a mapping file, which says how a table of the dataset is made: poses, points or nests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from scalar.data.description import Description
from scalar.data.located_table import did_you_mean, shorten
from scalar.data.sensor_formats import MeasuredTable
from scalar.ingest.column_profiles import ColumnProfiles
from scalar.ingest.mapping import (
    APPROACH,
    JOINT,
    OF_JOINT,
    TEXT_COLUMNS,
    Block,
    Column,
    FileRule,
    quantity_of,
)
from scalar.ingest.matching import NearestTime
from scalar.ingest.named_units import UNITS
from scalar.ingest.row_profiles import RowProfiles

_SI = {"length": "m", "angle": "rad"}


def read_mapping_block(
    given: Description,
    key: str,
    block: Mapping[str, Any],
    table: MeasuredTable | None,
    description: Description,
) -> Block:
    """Return a block of the mapping; its faults go to ``given.faults``.

    Args:
        given: The mapping file.
        key: Key of the block in the mapping file: ``poses``, ``points`` or ``nests``.
        block: Content of the block.
        table: The dataset's table of measurements, or for ``nests`` that of references; None if the sensor's kind has no such table.
        description: The dataset to be written.
    """
    columns = _columns(given, (key, "columns"), block["columns"], table, description)
    for name, entry in block.get("covariates", {}).items():
        columns[name] = _column(given, (key, "covariates", name), name, entry, None)
    targets = {
        target: _columns(given, (key, "targets", target), of_target, table, description)
        for target, of_target in block.get("targets", {}).items()
    }
    _check_dropped(given, key, block, [*columns, *(name for own in targets.values() for name in own)])
    row_profiles, column_profiles = _profiles(given, key, block)
    return Block(
        columns,
        tuple(map(_file_rule, block.get("files", []))),
        tuple(block.get("drop_without", [])),
        block.get("first_of_each"),
        block.get("euler_axes"),
        block.get("text", {}),
        row_profiles,
        column_profiles,
        block.get("rows_per_pose"),
        targets,
        block.get("rows_like", {}),
        block.get("matched_only", False),
        NearestTime.of(block.get("nearest_time")),
        tuple(block.get("drop_zeros", [])),
        block.get("rows_in_order", False),
    )


def _columns(
    given: Description,
    place: tuple[str, ...],
    entries: Mapping[str, Any],
    table: MeasuredTable | None,
    description: Description,
) -> dict[str, Column]:
    """Return the columns that stand at a place of the mapping file, by their names in the dataset; other arguments as above."""
    return {
        name: _column(given, (*place, name), name, entry, quantity_of(name, table, description))
        for name, entry in entries.items()
    }


def _file_rule(rule: Mapping[str, Any]) -> FileRule:
    """Return what an entry of ``files`` says."""
    return FileRule(
        rule["name"],
        {text: str(rule[text]) for text in TEXT_COLUMNS if text in rule},
        {name: float(value) for name, value in rule.get("covariates", {}).items()},
        rule.get("first_pose"),
        rule.get("add_to_pose", 0),
    )


def _check_dropped(given: Description, key: str, block: Mapping[str, Any], named: Iterable[str]) -> None:
    """Add the columns in ``drop_without`` and ``drop_zeros`` that are none of the columns ``named`` of the block to ``given.faults``."""
    named = list(named)
    for which in ("drop_without", "drop_zeros"):
        for i, name in enumerate(block.get(which, [])):
            if name not in named:
                hint = did_you_mean(name, named)
                given.fault(
                    (key, which, i),
                    f"no such column here ({shorten(name)}); {hint}write one of {', '.join(dict.fromkeys(named))}",
                )


def _profiles(
    given: Description, key: str, block: Mapping[str, Any]
) -> tuple[RowProfiles | None, ColumnProfiles | None]:
    """Return where the profiles stand in the rows, or in the columns, of a file; faults go to ``given.faults``."""
    of_rows, of_columns = block.get("row_profiles"), block.get("column_profiles")
    if of_rows is not None and of_columns is not None:
        given.fault(
            (key, "column_profiles"),
            "a profile is a row of the file or a column; remove row_profiles or this key",
        )
    if of_rows is not None and ("first_x" in of_rows) != ("step" in of_rows):
        given.fault((key, "row_profiles"), "first_x and step are given together; add the other one")
    return (
        None if of_rows is None else RowProfiles(**of_rows),
        None if of_columns is None else ColumnProfiles(**of_columns),
    )


def _column(
    given: Description, path: tuple[str | int, ...], name: str, entry: Mapping[str, Any], quantity: str | None
) -> Column:
    """Return how the dataset's column ``name`` is made from a column of a file; its faults go to ``given.faults``, under the key ``path``.

    Args:
        given: The mapping file.
        path: Keys that lead to ``entry``.
        name: Name of the column in the dataset.
        entry: What the mapping file states about the column.
        quantity: What the column holds, such as ``length``; None if its values have no unit.
    """
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
    for key in ("sign", "offset", "plus", "minus"):
        of_point = key in ("sign", "offset") and name in ("x", "y", "z")
        mirrored = key == "sign" and bool(OF_JOINT.fullmatch(name))
        counted = key == "offset" and name == "pose"
        if counted and key in entry and entry[key] != int(entry[key]):
            given.fault((*path, key), "poses have whole numbers; write one")
        if key in entry and not (JOINT.fullmatch(name) or of_point or mirrored or counted):
            given.fault((*path, key), "only joints have one; remove this key")
    if "plus" in entry and "minus" in entry:
        given.fault((*path, "minus"), "a column is added already by plus; keep one of the two keys")
    if "names" in entry and name not in TEXT_COLUMNS:
        given.fault((*path, "names"), f"only {', '.join(TEXT_COLUMNS)} have names; remove this key")
    if "values" in entry and not APPROACH.fullmatch(name):
        given.fault((*path, "values"), "only directions of approach have values; remove this key")
    to_si = units.get(unit or "", lambda value: value)
    offset, names = float(entry.get("offset", 0.0)), entry.get("names")
    sign, plus, minus = float(entry.get("sign", 1)), entry.get("plus"), entry.get("minus")
    values = {text: float(value) for text, value in entry["values"].items()} if "values" in entry else None
    return Column(
        entry["column"], to_si, sign, offset, plus, names, unit or "", "sign" in entry, values, minus
    )
