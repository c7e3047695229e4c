"""Read a grid of cases: a CSV file whose rows are scenes with some keys replaced. To add a case, add a row.

The column ``case`` names the row; every other column is the path of a key of the scene config, with dots
(``noise.range_noise_std_m``), or ``scene``, the scene's config file. An empty cell leaves the key as the scene
has it. Columns and values are checked against the scene's own schema when the grid is read: a misspelt key is
refused before anything runs.
"""

from __future__ import annotations

import copy
import csv
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from scalar.data.io.plain_yaml import resolve
from scalar.data.io.regular_file import read_regular_file
from scalar.data.located_table import did_you_mean
from scalar.data.schema_words import in_plain_words
from scalar.data.strict_schema import strict_validator
from scalar.errors import Fault, InvalidInput

CASE = "case"
SCENE = "scene"
MAX_BYTES = 100_000_000
"""Largest size of a grid's file [bytes], enough for a million cases."""
CASE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
"""A case's name, which is part of the names of files."""


@dataclass(frozen=True)
class Case:
    """One row of a grid.

    Attributes:
        name: name of the case, as ``CASE_NAME`` allows it.
        scene: config file of the scene, or None for that of the study.
        overrides: ``{dotted key: value}``, in the order of the columns.
    """

    name: str
    scene: str | None
    overrides: dict[str, Any]


def read_grid(path: str | Path) -> tuple[Case, ...]:
    """Return the cases of a grid file.

    Raises:
        InvalidInput: The file is at fault; every fault is listed with its row and column.
    """
    path = Path(path)
    try:
        text = read_regular_file(path, MAX_BYTES, str(path)).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidInput([Fault(str(path), f"cannot be read: {error}; save it as UTF-8 text")]) from None
    reader = csv.DictReader(text.splitlines())
    cases: list[Case] = []
    names: set[str] = set()
    try:
        faults = _column_faults(path.name, list(reader.fieldnames or ()))
        if faults:
            raise InvalidInput(faults)
        for row in reader:
            cases.append(_case(path.name, reader.line_num, row, names, faults))
    except csv.Error as error:
        message = f"not a table ({error}); save it as CSV text"
        raise InvalidInput([Fault(path.name, message, reader.line_num)]) from None
    if not cases:
        faults.append(Fault(path.name, "holds no case; write a row below the header"))
    if faults:
        raise InvalidInput(faults)
    return tuple(cases)


def with_overrides(config: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a scene config with some keys replaced, given by their paths with dots."""
    changed = copy.deepcopy(dict(config))
    for key, value in overrides.items():
        *parents, last = key.split(".")
        block = changed
        for parent in parents:
            block = block.setdefault(parent, {})
        block[last] = copy.deepcopy(value)
    return changed


@cache
def _schema() -> dict[str, Any]:
    # By its path, not by its package: importing scalar.simulation would need pybullet.
    text = resources.files("scalar").joinpath("simulation/schemas/scene.schema.json").read_text("utf-8")
    return json.loads(text)


def _resolved(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the definition to which a schema refers, or the schema itself if it refers to none."""
    return _schema()["$defs"][schema["$ref"].removeprefix("#/$defs/")] if "$ref" in schema else schema


def _schema_of(key: str) -> dict[str, Any] | str:
    """Return the schema of a key by its path with dots, or a sentence that says what is wrong with it."""
    schema = _schema()
    done: list[str] = []
    for part in key.split("."):
        known = _resolved(schema).get("properties", {})
        if part not in known:
            hint = did_you_mean(part, list(known))
            where = f"under {'.'.join(done)}" if done else "of a scene"
            return f"unknown key {part!r} {where}; {hint}the known keys are: {', '.join(known) or 'none'}"
        done.append(part)
        schema = known[part]
    return schema


def _column_faults(file: str, columns: list[str]) -> list[Fault]:
    """Return what is wrong with the header."""
    faults = []
    if CASE not in columns:
        faults.append(Fault(file, "the column is missing; it names each row", 1, CASE))
    for column in dict.fromkeys(columns):
        if columns.count(column) > 1:
            faults.append(Fault(file, f"{columns.count(column)} columns have this name; keep one", 1, column))
        problem = _schema_of(column) if column not in (CASE, SCENE) else {}
        if isinstance(problem, str):
            faults.append(Fault(file, problem, 1, column))
    return faults


def _case(file: str, line: int, row: Mapping[str, Any], names: set[str], faults: list[Fault]) -> Case:
    """Return the case of a row; add its name to `names`, and what is wrong with it to `faults`."""
    if None in row or None in row.values():
        faults.append(Fault(file, "has more or fewer cells than the header", line))
    name = (row.get(CASE) or "").strip()
    if not CASE_NAME.fullmatch(name):
        faults.append(
            Fault(file, f"{name!r} cannot name a case; use letters, digits, '_', '.' and '-'", line, CASE)
        )
    if name in names:
        faults.append(Fault(file, f"{name!r} names an earlier row too; rename one", line, CASE))
    names.add(name)
    overrides: dict[str, Any] = {}
    for column, cell in row.items():
        if column in (CASE, SCENE, None) or not isinstance(cell, str) or not cell.strip():
            continue
        value = resolve(cell.strip())
        schema = {"$defs": _schema()["$defs"], **_schema_of(column)}  # type: ignore[dict-item]
        for error in strict_validator(schema).iter_errors(value):
            faults += [Fault(file, message, line, column) for _, message in in_plain_words(error)]
        overrides[column] = value
    return Case(name, (row.get(SCENE) or "").strip() or None, overrides)
