"""Degrees and millimetres in tables of poses: by an option, or by a column's name (``q1_deg``, ``x_mm``).

A column such as ``q1`` holds a length if its joint is prismatic.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from scalar.data.io.csv_reader import split
from scalar.data.io.regular_file import MAX_TABLE_BYTES, read_regular_file
from scalar.data.io.semicolons import with_commas
from scalar.data.located_table import Layout, Table
from scalar.errors import Fault, InvalidInput
from scalar.units import DEG, MM

_JOINT = re.compile(r"q[0-9]+")
_ANGLE = re.compile(r"q[0-9]+|r[xyz]")
_TURN = re.compile(r"roll|pitch|yaw")
_LENGTH = re.compile(r"[xyz]")
_LENGTHS = {"m": 1.0, "mm": MM}
_ANGLES = {"rad": 1.0, "deg": DEG}


@dataclass(frozen=True)
class TableUnits:
    """The units of joint angles, places and rotation vectors in a table whose column names state none.

    Attributes:
        length: ``m`` or ``mm``.
        angle: ``rad`` or ``deg``.
        travels: Columns of prismatic joints, which hold lengths.
        turns: Further columns that hold angles: ``roll``, ``pitch`` and ``yaw`` where the table has frames.
    """

    length: str = "m"
    angle: str = "rad"
    travels: frozenset[str] = frozenset()
    turns: frozenset[str] = frozenset()

    @property
    def in_words(self) -> str:
        """Both units in a clause that ends a line, such as ``, lengths in mm, angles in deg``."""
        return f", lengths in {self.length}, angles in {self.angle}"

    def sliding(self, prismatic: Sequence[int]) -> TableUnits:
        """Return the same units for a robot with prismatic joints, given by their indices from 0."""
        return replace(self, travels=frozenset(f"q{i + 1}" for i in prismatic))

    def turning(self, columns: Sequence[str]) -> TableUnits:
        """Return the same units for a table in which these columns hold angles as well."""
        return replace(self, turns=frozenset(columns))

    def of(self, column: str) -> tuple[str, float]:
        """Return the unit of a column and its size in SI; an empty string and 1 for a column that is neither angle nor length."""
        known = self.known(column)
        if not known:
            return "", 1.0
        unit = self.length if known is _LENGTHS else self.angle
        return unit, known[unit]

    def known(self, column: str) -> dict[str, float]:
        """Return the units that a column may be in, with their sizes in SI; none if it is neither angle nor length."""
        if column in self.travels or _LENGTH.fullmatch(column):
            return _LENGTHS
        return _ANGLES if column in self.turns or _ANGLE.fullmatch(column) else {}

    def named(self, column: str) -> str:
        """Return the name of a column in a written table: with its unit at the end, unless that is SI."""
        unit, size = self.of(column)
        return f"{column}_{unit}" if size != 1.0 else column


SI = TableUnits()


def units_named(text: str | None) -> TableUnits:
    """Return the units of an option such as ``deg,mm``.

    Raises:
        InvalidInput: A word is no unit, or two are of one kind.
    """
    units: dict[str, str] = {}
    for word in (text or "").split(","):
        word = word.strip()
        kind = "length" if word in _LENGTHS else "angle" if word in _ANGLES else ""
        if word and (not kind or kind in units):
            raise InvalidInput(
                Fault("--units", f"{text!r} is not understood; write deg,mm, or one of deg, rad, mm, m")
            )
        if word:
            units[kind] = word
    return TableUnits(units.get("length", SI.length), units.get("angle", SI.angle))


def columns_of(path: Path) -> list[str]:
    """Return the names in the first line of a CSV file, unchecked.

    Raises:
        InvalidInput: The file cannot be read.
    """
    raw = read_regular_file(path, MAX_TABLE_BYTES).lstrip()
    line = with_commas(re.split(rb"[\r\n]", raw, maxsplit=1)[0]).decode("utf-8-sig", "replace")
    return split(line) or [name.strip().strip('"') for name in line.split(",")]


def units_to_write(text: str | None, columns: Sequence[str], prismatic: Sequence[int] = ()) -> TableUnits:
    """Return the units of a table that is written: those of an option such as ``deg,mm``, else those that the names of the columns read state.

    If there are joint angles, the names of their columns decide; other columns may be in other units. Degrees go with millimetres, unless
    the option states metres, or a joint's travel is read in metres.

    Args:
        text: The option, if it was given.
        columns: Names in the first line of the table that was read.
        prismatic: Indices, from 0, of the prismatic joints.

    Raises:
        InvalidInput: As for ``units_named``.
    """
    if text is not None:
        named = units_named(text)
        metres = any(word.strip() == SI.length for word in text.split(","))
        # A travel whose column states no unit is read in the unit of the option, which is metres here.
        metres = metres or any(f"q{i + 1}{end}" in columns for i in prismatic for end in ("", "_m"))
        return named if metres or named.angle != "deg" else replace(named, length="mm")
    spelt = [(base_name(column), column.rpartition("_")[2]) for column in columns]
    deciding = [(name, unit) for name, unit in spelt if _JOINT.fullmatch(name)] or [
        (name, unit) for name, unit in spelt if SI.known(name) or _TURN.fullmatch(name)
    ]
    stated = [unit if f"{name}_{unit}" in columns else "" for name, unit in deciding]
    all_degrees = bool(stated) and set(stated) == {"deg"}
    return TableUnits(
        "mm" if "mm" in stated or all_degrees else SI.length, "deg" if "deg" in stated else SI.angle
    )


def base_name(column: str) -> str:
    """Return the name of a column without the unit at its end."""
    name, _, unit = column.rpartition("_")
    known = (
        _ANGLES | _LENGTHS if _JOINT.fullmatch(name) else _ANGLES if _TURN.fullmatch(name) else SI.known(name)
    )
    return name if unit in known else column


@dataclass(frozen=True)
class FileUnits:
    """The units of one file.

    Attributes:
        units: Those of columns whose names state none.
        spelt: ``{name without unit: name in the file}`` of the columns whose names state a unit.
    """

    units: TableUnits
    spelt: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, columns: Sequence[str], units: TableUnits) -> FileUnits:
        """Return the units of a file with these columns; a name with a unit is left alone if the file has the name without a unit too."""
        spelt = {}
        for column in columns:
            name, _, unit = column.rpartition("_")
            if unit in units.known(name) and name not in columns:
                spelt[name] = column
        return cls(units, spelt)

    def layout(self, layout: Layout) -> Layout:
        """Return a layout whose required columns have their names in the file."""
        return replace(layout, required=tuple(self.spelt.get(name, name) for name in layout.required))

    def to_si(self, table: Table) -> None:
        """Convert the columns of a table to SI and rename them without units, in place."""
        plain = {spelt: name for name, spelt in self.spelt.items()}
        converted = {}
        for column, values in table.columns.items():
            name = plain.get(column, column)
            if column in plain:
                unit = column.rpartition("_")[2]
                size = (_ANGLES | _LENGTHS)[unit]
            else:
                size = self.units.of(column)[1]
            converted[name] = values if size == 1.0 or values.dtype == object else values * size
        table.columns = converted
        table.bad = {plain.get(column, column): bad for column, bad in table.bad.items()}
