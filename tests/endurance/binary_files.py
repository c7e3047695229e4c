"""Spreadsheets and matrices of MATLAB: good ones to damage, inside of what compresses them, and functions that import them."""

from __future__ import annotations

import random
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import openpyxl
from scipy.io import savemat

from scalar.data.io.plain_yaml import dump_yaml
from tests.endurance.commands import outcome
from tests.endurance.mutations import mutated
from tests.small_datasets import description, tables

NAMES = ["pose", *(f"q{i}" for i in range(1, 7)), "x", "y", "z"]


def _write_mapping(folder: Path, references: list[Any]) -> None:
    units = ["deg"] * 6 + ["mm"] * 3
    columns: dict[str, Any] = {"pose": {"column": references[0]}}
    for name, reference, unit in zip(NAMES[1:], references[1:], units, strict=True):
        columns[name] = {"column": reference, "unit": unit}
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {"columns": columns},
        "dataset": description("tracker"),
    }
    dump_yaml(mapping, folder / "mapping.yaml")


def _rows() -> list[list[float]]:
    both = tables("tracker")
    return both["poses"].merge(both["points"])[NAMES].to_numpy(dtype=float).tolist()


def write_spreadsheet(folder: Path) -> None:
    """Write a sheet with a header, and its mapping."""
    book = openpyxl.Workbook()
    sheet: Any = book.active
    for row in (NAMES, *_rows()):
        sheet.append(row)
    book.save(folder / "table.xlsx")
    _write_mapping(folder, list(NAMES))


def write_matrix(folder: Path) -> None:
    """Write a matrix that is not compressed, so that damage reaches its numbers, and its mapping."""
    savemat(folder / "table.mat", {"measured": _rows()})
    _write_mapping(folder, list(range(1, len(NAMES) + 1)))


def importer(name: str) -> Callable[[Path], str]:
    """Return a function that returns what ``scalar import`` says and writes."""

    def read(folder: Path) -> str:
        out = folder.parent / f"{folder.name}-imported"
        return outcome(["import", folder / "mapping.yaml", folder / name, "-o", out], out)

    return read


def mutated_within(raw: bytes, rng: random.Random) -> bytes:
    """Return a spreadsheet in which one of its files is damaged, and in one of ten the archive itself."""
    if rng.random() < 0.1:
        return mutated(raw, rng)
    with ZipFile(BytesIO(raw)) as sound:
        members = {name: sound.read(name) for name in sound.namelist()}
    name = rng.choice([name for name in members if "sheet" in name] * 3 + list(members))
    members[name] = mutated(members[name], rng)
    changed = BytesIO()
    with ZipFile(changed, "w", ZIP_DEFLATED) as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return changed.getvalue()
