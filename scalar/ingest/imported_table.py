"""A table for a dataset whose rows come from foreign files: its faults name the foreign file, its row and its column."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from scalar.data.located_table import Table
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array

MEASURED_AT = "_time"
"""The column of points, as they are read, with the time at which they were measured; it is taken out before the table is written."""


@dataclass
class ImportedTable(Table):
    """A table for a dataset whose rows come from foreign files.

    Attributes:
        files: ``(N,)``, the name of the file from which each row comes.
        labels: ``{column of the dataset: its name in the files}``.
        midnight: the midnight after which its times count, in seconds of the Unix epoch; None if they have no dates.
    """

    translated: ClassVar[str] = (
        "; or translate it by names of this column in the mapping: names: {'1': floor}"
    )
    files: Array = field(default_factory=lambda: np.empty(0, dtype=object))
    labels: dict[str, str] = field(default_factory=dict)
    midnight: float | None = None

    def file_of(self, row: int) -> str:
        """Return the name of the foreign file that a row is from."""
        return str(self.files[row])

    def report(self, faults: list[Fault], column: str, mask: Array, message: Callable[[int], str]) -> None:
        """Add a fault for every row at which ``mask`` ``(N,)`` is True; it names the foreign file, row and column from which the cell comes."""
        found: list[Fault] = []
        rows = np.flatnonzero(mask & ~self.bad.get(column, np.zeros(self.n_rows, dtype=bool)))
        super().report(found, column, mask, message)
        for k, fault in enumerate(found):
            # A fault without a row says how many more there are, to the last.
            row = rows[-1 if fault.row is None else k]
            file = self.files[row]
            faults.append(replace(fault, file=file, column=self.labels.get(column, column)))


def select_rows(table: ImportedTable, keep: Array) -> ImportedTable:
    """Return the rows of a table that ``keep`` selects, a mask ``(N,)`` or indices."""
    lines = table.line_numbers()[keep]
    columns = {name: values[keep] for name, values in table.columns.items()}
    return replace(table, columns=columns, line_numbers=lambda: lines, files=table.files[keep], bad={})


def joined(tables: Sequence[ImportedTable]) -> ImportedTable:
    """Return the rows of several tables as one, with times that have dates all after the first midnight of them.

    Raises:
        InvalidInput: The tables do not have the same columns, or some have times with dates and others times without.
    """
    lines = np.concatenate([table.line_numbers() for table in tables])
    first = tables[0]
    faults = [
        Fault(
            table.file,
            f"{name} is given for this file or for {first.file} only; give it for all files, or for none",
        )
        for table in tables
        for name in sorted(table.columns.keys() ^ first.columns.keys())
    ]
    if faults:
        raise InvalidInput(faults)
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in first.columns}
    files = np.concatenate([table.files for table in tables])
    midnights = [table.midnight for table in tables if table.midnight is not None]
    if not midnights:
        return replace(first, columns=columns, line_numbers=lambda: lines, files=files, bad={})
    dated = next(table.file for table in tables if table.midnight is not None)
    message = f"its times have no dates, and those of {dated} have: write dates with the times in all files, or in none"
    if faults := [Fault(table.file, message) for table in tables if table.midnight is None]:
        raise InvalidInput(faults)
    together = min(midnights)
    shift = np.repeat([midnight - together for midnight in midnights], [table.n_rows for table in tables])
    for name in {"time", MEASURED_AT} & columns.keys():
        columns[name] = columns[name] + shift
    return replace(first, columns=columns, line_numbers=lambda: lines, files=files, bad={}, midnight=together)


def by_file(table: ImportedTable) -> list[ImportedTable]:
    """Return the rows of each file as a table that is named after the file."""
    names = dict.fromkeys(table.files)
    return [replace(select_rows(table, np.flatnonzero(table.files == name)), file=name) for name in names]
