"""Rows of foreign files that a mapping leaves out, and how they are named."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.ingest.imported_table import ImportedTable, by_file, select_rows

_ROWS_SHOWN = 12


@dataclass(frozen=True)
class LeftOut:
    """Rows of a file that the mapping leaves out.

    Attributes:
        file: Its name.
        rows: Numbers of the rows, as an editor counts them; a row that is a whole profile stands there once for each point that is left out.
        why: Why they are left out, such as ``without column X (drop_without)``, with the key of the mapping in brackets.
    """

    file: str
    rows: tuple[int, ...]
    why: str

    def __str__(self) -> str:
        """Return a line for a person."""
        rows = list(dict.fromkeys(self.rows))
        if len(rows) < len(self.rows):
            return f"{self.file}: {len(self.rows)} points in {len(rows)} rows left out, {self.why}"
        shown = ", ".join(map(str, rows[:_ROWS_SHOWN]))
        more = f" and {len(rows) - _ROWS_SHOWN} more" if len(rows) > _ROWS_SHOWN else ""
        return (
            f"{self.file}: {len(rows)} row{'s' if len(rows) > 1 else ''} left out, {self.why}: {shown}{more}"
        )


def left_out_rows(table: ImportedTable, rows: Array, why: str) -> list[LeftOut]:
    """Return what to say of rows ``(N,)`` bool of a table that are left out, file by file."""
    if not rows.any():
        return []
    return [
        LeftOut(part.file, tuple(int(line) for line in part.line_numbers()), why)
        for part in by_file(select_rows(table, np.flatnonzero(rows)))
    ]
