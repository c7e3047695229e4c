"""A foreign table as its file has it: only numbers are interpreted, and every row keeps the number of its line in the file."""

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Self

import numpy as np

from scalar.data.located_table import HEADER_AGAIN, did_you_mean, shorten
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.pose_names import numbers_of_names, several_kinds
from scalar.ingest.written_numbers import MAPPED, Written
from scalar.ingest.written_times import Unsettled, is_date, read_times

Reference = str | int
"""A column of a file by its name, or by its number, the first being 1."""
FILE_NUMBER = "@file_number"
"""The column that holds the number in the file's name, for files whose names contain the number of their pose."""
ROW = "@row"
"""The column that counts the rows of a file's table from 1."""
POSE, ROW_OF_POSE = "@pose", "@row_of_pose"
"""The columns that say to which pose a row belongs and which of its rows it is, both from 1, where each pose has the same number of rows."""
HEAD_NUMBER = "@head_number"
"""The column that holds the number in the header of a profile's column, where each column of a file is a profile."""
MOST_COLUMNS = 10_000  # of a foreign table: a profile in a row has up to some thousand values
_MAX_WRONG = 10  # most cells of one column that are listed as not being numbers
_MANY_ALIKE = 3  # cells that are no numbers above which one line is said for all, if one change of the mapping mends them
MISSING = frozenset({"", "nan", "na", "n/a", "null"})


@dataclass(frozen=True, eq=False)
class RawTable:
    """A table as its file has it.

    Attributes:
        file: name of the file.
        names: names of the columns; None if they have only numbers.
        cells: the cells of each column, ``(N,)``: text as objects, or float64 from a matrix.
        lines: ``(N,)`` int, the line or matrix row of each row.
        written: how text writes its numbers.
        missing: texts, in lower case, which mean that nothing was measured.
        number: the last whole number in the file's name, which the column ``@file_number`` holds in every row; None if there is none.
        rows_per_pose: how many successive rows belong to each pose, which the columns ``@pose`` and ``@row_of_pose`` count; None if nothing says so.
        dates: the order of day, month and year in dates that end in the year, as the mapping states it; None if it does not.
    """

    file: str
    names: tuple[str, ...] | None
    cells: tuple[Array, ...]
    lines: Array
    written: Written = field(default_factory=Written)
    missing: frozenset[str] = MISSING
    number: int | None = None
    rows_per_pose: int | None = None
    dates: str | None = None

    def find(self, reference: Reference) -> int:
        """Return the position of a column.

        Raises:
            InvalidInput: there is none of that name or number, or there are several.
        """
        if isinstance(reference, int):
            if not 1 <= reference <= len(self.cells):
                message = f"there is no column {reference}; the file has {len(self.cells)}"
                raise InvalidInput(Fault(self.file, message))
            return reference - 1
        if self.names is None:
            raise InvalidInput(
                Fault(self.file, f"its columns have no names; write a number for {reference!r}")
            )
        reference = unicodedata.normalize("NFC", reference)
        if (count := self.names.count(reference)) == 1:
            return self.names.index(reference)
        if count:
            message = f"{count} columns are called so; give its number"
        else:
            named = ", ".join(repr(name) for name in dict.fromkeys(self.names))
            hint = did_you_mean(reference, list(self.names))
            message = f"no such column; {hint}the file has {shorten(named, 300)[1:-1]}"
        raise InvalidInput(Fault(self.file, message, column=self.label(reference)))

    def label(self, reference: Reference) -> str:
        """Return how a fault names a column: with the word ``column``, which faults of .csv and .parquet files add themselves."""
        name = str(reference)
        return name if self.file.endswith((".csv", ".parquet")) else f"column {name}"

    def text(self, reference: Reference) -> tuple[Array, Array]:
        """Return a column as text ``(N,)``, and in which rows nothing was measured, ``(N,)`` bool."""
        cells = self._cells(reference)
        if cells.dtype != object:
            text = np.array([f"{value:.15g}" for value in cells], dtype=object)
            return text, np.isnan(cells)
        return cells, self._is_missing(cells)

    def numbers(self, reference: Reference, faults: list[Fault]) -> tuple[Array, Array]:
        """Return a column as numbers ``(N,)``, NaN where there is none, and in which rows nothing was measured, ``(N,)`` bool.

        Every other cell that is not a number is added to `faults`.
        """
        cells = self._cells(reference)
        if cells.dtype != object:
            return cells, np.isnan(cells)
        missing = self._is_missing(cells)
        values = np.full(len(cells), np.nan)
        if set(cells[~missing]) == {"+", "-"}:  # directions
            values[~missing] = np.where(cells[~missing] == "+", 1.0, -1.0)
            return values, missing
        wrong = []
        for i in np.flatnonzero(~missing):
            cell = cells[i]
            value = self.written.number(cell)
            if value is None:
                wrong.append(i)
            else:
                values[i] = value
        self._report_no_numbers(reference, cells, wrong, int(np.sum(~missing)), faults)
        return values, missing

    def _report_no_numbers(
        self, reference: Reference, cells: Array, wrong: list[int], filled: int, faults: list[Fault]
    ) -> None:
        """Add faults for cells that are no numbers: one for each, or one for all if no cell is a number, or if one change of the mapping mends many.

        Args:
            reference: The column.
            cells: Its cells, ``(N,)``.
            wrong: The rows whose cells are no numbers.
            filled: Number of cells that hold something.
            faults: Is extended.
        """
        others = [i for i in wrong if unicodedata.normalize("NFC", str(cells[i])) != reference]
        faults += [  # once for all columns
            Fault(self.file, HEADER_AGAIN, int(self.lines[i])) for i in wrong[:_MAX_WRONG] if i not in others
        ]
        remedies = [self.written.hint(str(cells[i]), self._texts()) for i in others[:_MAX_WRONG]]
        none_is = len(others) > _MAX_WRONG and len(others) == filled
        in_one = none_is or (len(others) > _MANY_ALIKE and len(set(remedies)) == 1 and MAPPED in remedies[0])
        for i, remedy in zip(others[: 1 if in_one else None], remedies, strict=False):
            what = f"not a number ({shorten(cells[i])})"
            if in_one:
                count = (
                    f"none of the {filled} cells is a number"
                    if none_is
                    else f"{len(others)} cells are no numbers"
                )
                what = f"{count}; the first is {shorten(cells[i])}"
            message = f"{what}: {remedy}; where it means that nothing was measured, add it to text.missing and use drop_without"
            faults.append(Fault(self.file, message, int(self.lines[i]), self.label(reference)))
        if len(others) > _MAX_WRONG and not in_one:
            message = f"{len(others) - _MAX_WRONG} more rows with the same fault; look for a common cause"
            faults.append(Fault(self.file, message, column=self.label(reference)))

    def seconds(self, reference: Reference, faults: list[Fault]) -> tuple[Array, Array, float | None]:
        """Return the column of times [s] as ``numbers`` does, and the midnight after which dates are counted, in seconds of the Unix epoch.

        Times of day (``09:04:30``) are counted from midnight, and if they have their date, from the midnight before the earliest; the last of the
        three is None for all but dates.
        """
        cells = self._cells(reference)
        if cells.dtype == object:
            missing = self._is_missing(cells)
            values = np.full(len(cells), np.nan)
            clock = read_times([str(cell) for cell in cells[~missing]], self.dates)
            if isinstance(clock, Unsettled):
                row = int(self.lines[~missing][clock.row])
                faults.append(Fault(self.file, clock.message, row, self.label(reference)))
                return values, missing, None
            if clock is not None:
                values[~missing] = clock.seconds
                return values, missing, clock.midnight
            dates = [i for i in np.flatnonzero(~missing) if is_date(str(cells[i]))]
            if dates:
                message = (
                    f"a date ({shorten(cells[dates[0]])}), and such dates are not read; write seconds, 09:04:30, 2026-11-26 09:04:30, "
                    "26.11.2026 09:04:30 or 11/26/2026 9:04:30 AM, all of a column alike, and with a time zone in all or none"
                )
                faults.append(Fault(self.file, message, int(self.lines[dates[0]]), self.label(reference)))
                return values, missing, None
        return *self.numbers(reference, faults), None

    def pose_numbers(self, reference: Reference, faults: list[Fault]) -> tuple[Array, Array]:
        """Return the column of pose numbers as ``numbers`` does; names such as ``P017``, alike but for one whole number, are taken for it."""
        cells = self._cells(reference)
        if cells.dtype == object:
            missing = self._is_missing(cells)
            names = [str(cell) for cell in cells[~missing]]
            values = np.full(len(cells), np.nan)
            if (found := numbers_of_names(names)) is not None:
                values[~missing] = found
                return values, missing
            if message := several_kinds(names, str(reference)):
                faults.append(Fault(self.file, message, column=self.label(reference)))
                return values, missing
        return self.numbers(reference, faults)

    def _cells(self, reference: Reference) -> Array:
        """Return the cells of a column, or the numbers that count rows, poses or files in its place."""
        if reference == HEAD_NUMBER and HEAD_NUMBER not in (self.names or ()):
            message = (
                f"{HEAD_NUMBER} needs points.column_profiles, and a number of its own in the header of every profile; if both files have the poses "
                f"in the same order, write {ROW} in both blocks"
            )
            raise InvalidInput(Fault(self.file, message))
        if reference == ROW and ROW not in (self.names or ()):
            return np.arange(1.0, len(self.lines) + 1.0)
        if reference in (POSE, ROW_OF_POSE) and reference not in (self.names or ()):
            return self._count_by_pose(reference)
        if reference != FILE_NUMBER:
            return self.cells[self.find(reference)]
        if self.number is None:
            raise InvalidInput(
                Fault(self.file, f"its name has no number for {FILE_NUMBER}; rename it, as in scan_17")
            )
        return np.full(len(self.lines), float(self.number))

    def _count_by_pose(self, reference: Reference) -> Array:
        """Return the column ``@pose`` or ``@row_of_pose``, ``(N,)``.

        Raises:
            InvalidInput: nothing says how many rows a pose has, or the rows are no multiple of it.
        """
        n, each = len(self.lines), self.rows_per_pose
        if each is None:
            message = f"{reference} needs points.rows_per_pose, the number of successive rows of each pose; add it to the mapping"
            raise InvalidInput(Fault(self.file, message))
        if n % each:
            message = f"{n} rows are no multiple of points.rows_per_pose ({each}); correct it, or give the file a column with the number of the pose"
            raise InvalidInput(Fault(self.file, message))
        rows = np.arange(n)
        return 1.0 + (rows // each if reference == POSE else rows % each)

    def like(self, patterns: Mapping[str, str]) -> Array:
        """Return in which rows ``(N,)`` the cell of every column is like its pattern, in which ``*`` stands for any text.

        Columns are given by name, or by number if no column is called so.

        Raises:
            InvalidInput: A column is missing.
        """
        fits = np.ones(len(self.lines), dtype=bool)
        for name, pattern in patterns.items():
            column = int(name) if name.isdecimal() and name not in (self.names or ()) else name
            fits &= [fnmatchcase(cell, pattern) for cell in self.text(column)[0]]
        return fits

    def of_rows(self, rows: Array) -> Self:
        """Return the table of some rows, ``(N,)`` bool."""
        return replace(self, cells=tuple(cells[rows] for cells in self.cells), lines=self.lines[rows])

    def _texts(self) -> Iterator[str]:
        """Yield the cells that hold text."""
        return (str(cell) for column in self.cells if column.dtype == object for cell in column)

    def _is_missing(self, cells: Array) -> Array:
        return np.array([cell.lower() in self.missing for cell in cells], dtype=bool)


def last_number(text: str) -> int | None:
    """Return the last whole number in a text, as in the name of a file or the header of a column; None if there is none."""
    numbers = re.findall("[0-9]+", text)
    return int(numbers[-1]) if numbers else None
