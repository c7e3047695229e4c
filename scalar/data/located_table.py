"""A table of numbers and text whose faults are reported with their row and column.

A row is the line that a text editor shows, the header being line 1; rows of a Parquet file count from 1.
Files are read in `scalar.data.io.csv_reader` and `scalar.data.io.parquet_reader`.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import partial

import numpy as np

from scalar.data.columns_in_other_units import in_another_unit
from scalar.errors import Fault

MISSING_COLUMN = "the column is missing"
SEPARATED = "cells are separated by"
HEADER_AGAIN = (
    "the names of the columns stand here again, as where two tables were joined; remove this row, and see whether the numbers of poses after it "
    "begin anew"
)
MAX_SHOWN = 100
"""Most faults of one kind in one column that are listed; one more line counts the rest."""
_ROWS_SHOWN = 3  # rows that are listed of a label that is wrong in several
# More rows than so many are reported in one line if they have the same fault, or if they are all rows of the table.
_MANY_ROWS = 10
_IDS_SHOWN = 3  # poses that are reported one by one; more poses than these are reported in one line
MAX_COLUMNS = 2000
"""Most columns of a table that is read; the log of a robot has hundreds."""
_LONGEST_NAME = 200  # characters; a longer one resembles no name that is known, and comparing a file without separators takes minutes
MAX_INTEGER = 2.0**53  # the largest up to which float64 holds every integer
MAX_NUMBER = 1e100
"""Largest number in a table; products of a few such numbers still fit into float64."""

NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
"""A number as tables may write it."""


@dataclass(frozen=True)
class Layout:
    """Which columns a table may have.

    Attributes:
        required: columns that have to be there.
        optional: columns that are known and may be there.
        text: columns that hold text; all others hold numbers.
        integers: columns that hold integers.
        extras: whether further numeric columns are kept.
        semicolons: whether the cells of a file may be separated by semicolons, with decimal commas.
        copied: whether further columns that are not all numbers are kept as well, as the text that stands there.
        blank: columns of numbers in which a cell may be empty; NaN then stands for it.
        other_names: names under which columns are known elsewhere, and how they are called here; a fault of the former suggests the latter.
        refuse: returns what is wrong with a column of that name, or None.
    """

    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    text: frozenset[str] = frozenset()
    integers: frozenset[str] = frozenset({"pose"})
    extras: bool = False
    refuse: Callable[[str], str | None] = lambda _: None
    copied: bool = False
    semicolons: bool = False
    blank: frozenset[str] = frozenset()
    other_names: Mapping[str, str] = field(default_factory=dict)


@dataclass
class Table:
    """The columns of one file; float64 or text (object), each of the same length.

    Attributes:
        file: name of the file.
        columns: the columns by name, in the order of the file; float64 ``(N,)``, or text as objects.
        line_numbers: returns the row in the file of each entry, ``(N,)``, counted as the module's docstring says.
        bad: for each column the cells that have been reported already, ``(N,)`` bool.
        whole: False if rows of the file had to be left out, so that what is missing here may stand in the file.
    """

    file: str
    columns: dict[str, np.ndarray]
    line_numbers: Callable[[], np.ndarray]
    whole: bool = True
    bad: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def n_rows(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.columns.values()))) if self.columns else 0

    def good(self, *names: str) -> bool:
        """Return whether these columns are all there and hold no faulty cell."""
        return all(name in self.columns and not np.any(self.bad.get(name, False)) for name in names)

    def report(
        self, faults: list[Fault], column: str, mask: np.ndarray, message: Callable[[int], str]
    ) -> None:
        """Add a fault for every row of `mask` that was not reported for this column before."""
        bad = self.bad.setdefault(column, np.zeros(self.n_rows, dtype=bool))
        rows = np.flatnonzero(mask & ~bad)
        if not rows.size:
            return
        bad[rows] = True
        lines = self.line_numbers()
        texts = [message(int(i)) for i in rows[:MAX_SHOWN]]
        if rows.size > _MANY_ROWS and (rows.size == self.n_rows or len(set(texts)) == 1):
            some = ", ".join(str(line) for line in lines[rows[:_ROWS_SHOWN]])
            which = "all" if rows.size == self.n_rows else f"{some}, ..."
            text = f"{texts[0]} ({rows.size} rows with this fault: {which})"
            faults.append(Fault(self.file, text, int(lines[rows[0]]), column))
            return
        faults += [
            Fault(self.file, text, int(lines[i]), column)
            for text, i in zip(texts, rows[:MAX_SHOWN], strict=True)
        ]
        if rows.size > MAX_SHOWN:
            more = f"{rows.size - MAX_SHOWN} more rows with the same fault, the last in row {lines[rows[-1]]}"
            faults.append(Fault(self.file, f"{more}; look for a common cause", column=column))

    def file_of(self, row: int) -> str:
        """Return the name of the file that an entry is from."""
        return self.file

    def report_ids(
        self,
        faults: list[Fault],
        column: str,
        mask: np.ndarray,
        one: Callable[[int], str],
        all_of: Callable[[int, str], str],
    ) -> None:
        """Add a fault for every number in the rows of `mask`, at its first row; one for all of them if there are many.

        Args:
            faults: The list to which they are added.
            column: A column of numbers that name poses.
            mask: ``(N,)`` bool.
            one: Returns the message about the number in a row.
            all_of: Returns the message about many, from their count and words such as ``5, 6, 7, ... (95 rows: 7, 8, 9, ...)``.
        """
        mask = mask & ~self.bad.get(column, np.zeros(self.n_rows, dtype=bool))
        rows = np.flatnonzero(mask)
        ids = self.columns[column][rows]
        values, first = np.unique(ids, return_index=True)
        start = np.zeros(self.n_rows, dtype=bool)
        if len(values) <= _IDS_SHOWN:
            start[rows[first]] = True
            self.report(faults, column, start, one)
        else:
            lines = [str(line) for line in self.line_numbers()[rows[:_ROWS_SHOWN]]]
            names = [f"{ids[i]:.15g}" for i in np.sort(first)[:_ROWS_SHOWN]]
            text = all_of(len(values), f"{', '.join(names)}, ... ({len(rows)} rows: {', '.join(lines)}, ...)")
            start[rows[0]] = True
            self.report(faults, column, start, lambda _: text)
        if rows.size:
            self.bad[column] |= mask

    def report_labels(
        self, faults: list[Fault], column: str, mask: np.ndarray, message: Callable[[int], str]
    ) -> None:
        """Add a fault for every label in the rows of `mask`, at its first row; where several have it, with their number and the first of them."""
        bad = self.bad.get(column, np.zeros(self.n_rows, dtype=bool))
        rows_of: dict[tuple[str, str], list[int]] = {}
        for i in np.flatnonzero(mask & ~bad).tolist():
            rows_of.setdefault((self.file_of(i), str(self.columns[column][i])), []).append(i)
        alike = {rows[0]: rows for rows in rows_of.values()}
        lines = self.line_numbers()

        def with_rows(i: int) -> str:
            rows = alike[i]
            if len(rows) == 1:
                return message(i)
            shown = [str(lines[row]) for row in rows[:_ROWS_SHOWN]]
            more = ", ..." if len(rows) > _ROWS_SHOWN else ""
            return f"{message(i)} ({len(rows)} rows: {', '.join(shown)}{more})"

        self.report(faults, column, np.isin(np.arange(self.n_rows), list(alike)), with_rows)
        if alike:
            self.bad[column] |= mask


def did_you_mean(name: str, known: list[str]) -> str:
    """Return ``did you mean 'noise'? `` if a known name resembles `name`, else an empty text."""
    meant = closest(name, known, 0.6) if len(name) <= _LONGEST_NAME else ""
    return f"did you mean {meant!r}? " if meant else ""


def closest(name: str, known: Sequence[str], least: float) -> str:
    """Return the known name that resembles `name` most, upper and lower case alike; empty if none has a similarity of at least `least`."""
    by_lower = {candidate.lower(): candidate for candidate in reversed(known)}
    close = get_close_matches(name.lower(), list(by_lower), n=1, cutoff=least)
    return by_lower[close[0]] if close else ""


def of_the_same_joint(name: str, unknown: Sequence[str]) -> str:
    """Return the one unknown column that has the number of a joint's column and no other, as ``J3`` or ``joint_3`` for ``q3``; else an empty text."""
    number = re.fullmatch(r"q([1-9][0-9]*)", name)
    if not number:
        return ""
    same = [column for column in unknown if re.findall("[0-9]+", column) == [number[1]]]
    return same[0] if len(same) == 1 and len(same[0]) <= _LONGEST_NAME else ""


def shorten(value: object, width: int = 40) -> str:
    """Return the representation of `value`, cut to `width` characters."""
    text = repr(value)
    return text if len(text) <= width else text[: width - 4] + "..." + text[-1]


def too_many_columns(count: int, most: int = MAX_COLUMNS) -> str:
    """Return the message about a table with more columns than are read."""
    return f"{count} columns, and at most {most} are read; keep those that are needed"


def header_faults(file: str, names: list[str], layout: Layout, row: int | None = 1) -> list[Fault]:
    """Return the faults of the names of the columns.

    Args:
        file: Name of the file, for messages.
        names: The names, in the order of the columns.
        layout: Which columns the file has to have and may have.
        row: The row in which the names stand, for messages; None if there are no rows to count (arrays in memory).
    """
    wanted = ",".join(layout.required or layout.optional)
    if len(names) > MAX_COLUMNS:
        return [Fault(file, too_many_columns(len(names)), row)]
    for sign, called in ((";", "';'"), ("\t", "tabs")):
        if len(names) == 1 and sign in names[0]:
            message = f"{SEPARATED} {called}; separate them by commas, and write decimal points"
            return [Fault(file, f"{message}: {wanted}" if layout.required else message, row)]
    if all(NUMBER.fullmatch(name) for name in names):
        return [Fault(file, f"there is no header; the first line has to be {wanted}", row)]
    faults = []
    known = [*layout.required, *layout.optional]
    unknown = [name for name in names if name not in known]
    missing = [name for name in layout.required if name not in names]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            faults.append(
                Fault(file, f"{names.count(name)} columns have this name; keep one", row, name or None)
            )
        elif not name:
            faults.append(Fault(file, "a column without a name; name it or remove it", row))
        elif name in unknown and (message := layout.refuse(name)):
            faults.append(Fault(file, message, row, name))
        elif name in unknown and not layout.extras and not any(in_another_unit(m, [name]) for m in missing):
            elsewhere = layout.other_names.get(name.lower())
            hint = f"did you mean {elsewhere!r}? " if elsewhere else did_you_mean(name, known)
            message = f"an unknown column; {hint}the columns are {wanted}; remove or rename it"
            faults.append(Fault(file, message, row, name))
    for name in missing:
        likely = closest(name, unknown, 0.6) or of_the_same_joint(name, unknown)
        hint = in_another_unit(name, unknown) or (f"is it {likely!r}? rename it; " if likely else "")
        faults.append(Fault(file, f"{MISSING_COLUMN}; {hint}the header has to name {wanted}", row, name))
    return faults


def check_cells(table: Table, layout: Layout, faults: list[Fault]) -> None:
    """Report empty texts, numbers that are not finite or beyond ``MAX_NUMBER``, and integers that are not whole or beyond ``MAX_INTEGER``."""
    for name, values in table.columns.items():
        if values.dtype == object and name not in layout.text:  # copied as it is
            continue
        if name in layout.text:
            empty = np.array([not cell for cell in values], dtype=bool)
            table.report(faults, name, empty, lambda i: "an empty cell; fill it in, or remove the row")
            continue
        finite = np.isfinite(values) | (np.isnan(values) & (name in layout.blank))
        table.report(faults, name, ~finite, partial(_not_finite, values))
        if name in layout.integers:
            broken = finite & ((np.nan_to_num(values) % 1.0 != 0.0) | (np.abs(values) > MAX_INTEGER))
            table.report(faults, name, broken, partial(_not_an_integer, values))
        else:
            table.report(faults, name, finite & (np.abs(values) > MAX_NUMBER), partial(_too_large, values))


def _not_finite(values: np.ndarray, i: int) -> str:
    return f"not a finite number ({values[i]}); write the number, or remove the row"


def _too_large(values: np.ndarray, i: int) -> str:
    return f"too large a number ({values[i]:g}); correct it, or remove the row"


def _not_an_integer(values: np.ndarray, i: int) -> str:
    return f"not an integer ({values[i]:.17g}); write one as 17"
