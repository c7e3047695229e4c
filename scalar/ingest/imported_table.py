"""A table of ours whose rows come from foreign files: its faults name the file, the row and the column that the user knows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from scalar.data.located_table import Table
from scalar.errors import Fault, InvalidInput

_UNLIKE = "in all files or in none; name it for each, or for none"


@dataclass
class ImportedTable(Table):
    """A table of ours whose rows come from foreign files, in which its faults are named.

    Attributes:
        files: ``(N,)`` the name of the file that each row comes from.
        labels: by our column, what the files call it.
    """

    files: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=object))
    labels: dict[str, str] = field(default_factory=dict)

    def report(
        self, faults: list[Fault], column: str, mask: np.ndarray, message: Callable[[int], str]
    ) -> None:
        """Add a fault for every row of `mask`, in the words of the file it comes from."""
        found: list[Fault] = []
        super().report(found, column, mask, message)
        rows = iter(np.flatnonzero(mask))
        for fault in found:
            file = self.files[next(rows)] if fault.row is not None else self.file
            faults.append(replace(fault, file=file, column=self.labels.get(column, column)))


def select_rows(table: ImportedTable, keep: np.ndarray) -> ImportedTable:
    """Return some rows of a table."""
    lines = table.line_numbers()[keep]
    columns = {name: values[keep] for name, values in table.columns.items()}
    return replace(table, columns=columns, line_numbers=lambda: lines, files=table.files[keep], bad={})


def joined(tables: Sequence[ImportedTable]) -> ImportedTable:
    """Return tables below one another; all have the same columns."""
    lines = np.concatenate([table.line_numbers() for table in tables])
    first = tables[0]
    faults = [
        Fault(table.file, f"{name} is known of this file or of {first.file} only, and has to be {_UNLIKE}")
        for table in tables
        for name in sorted(table.columns.keys() ^ first.columns.keys())
    ]
    if faults:
        raise InvalidInput(faults)
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in first.columns}
    files = np.concatenate([table.files for table in tables])
    return replace(first, columns=columns, line_numbers=lambda: lines, files=files, bad={})


def by_file(table: ImportedTable) -> list[ImportedTable]:
    """Return the rows of each file as a table of that file's name."""
    names = dict.fromkeys(table.files)
    return [replace(select_rows(table, np.flatnonzero(table.files == name)), file=name) for name in names]
