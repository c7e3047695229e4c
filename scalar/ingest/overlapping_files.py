"""Whether two files of a table share a part of their rows: a log that was saved twice, the second time with more rows.

Measured numbers scatter, so that a run of rows with the same ones was measured once. Where rows have no number of their pose, they would count twice
without a word. Single rows that are the same, here and there, are no such run: a program that runs twice repeats them if its numbers are rounded.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from scalar.errors import Fault
from scalar.ingest.imported_table import ImportedTable
from scalar.ingest.merged_scans import SCAN

_LEAST_ROWS = 2  # chosen: a single row may be the same by chance
_LEAST_MEASURED = 3  # numbers of a row; profiles repeat single ones
_LINES_SHOWN = 3  # pairs of files that have a line of their own


def report_overlaps(tables: Sequence[ImportedTable], measured: Collection[str], faults: list[Fault]) -> None:
    """Add a fault for each file that shares a run of its rows with an earlier one; a few at most.

    Args:
        tables: The files of a block, as they were read.
        measured: The columns that the sensor measures.
        faults: Where they are added.
    """
    names = [name for name in measured if tables and name in tables[0].columns]
    if len(tables) < 2 or len(names) < _LEAST_MEASURED:
        return
    seen: dict[bytes, tuple[str, int]] = {}
    found: list[Fault] = []
    for table in tables:
        lines, keys = table.line_numbers(), _keys(table, names)
        shared: dict[str, list[int]] = {}
        for i, key in enumerate(keys):
            if key and key in seen and seen[key][0] != table.file:
                shared.setdefault(seen[key][0], []).append(i)
        for other, rows in shared.items():
            one_run = rows[-1] - rows[0] == len(rows) - 1 and len({keys[i] for i in rows}) == len(rows)
            if len(rows) >= _LEAST_ROWS and one_run:
                message = (
                    f"{len(rows)} of its {table.n_rows} rows, from this one on, stand in {other} too, from row {seen[keys[rows[0]]][1]} on, so "
                    "that each would count twice; leave them out of one of the files"
                )
                found.append(Fault(table.file, message, int(lines[rows[0]])))
        seen |= {key: (table.file, int(lines[i])) for i, key in enumerate(keys) if key and key not in seen}
    if more := found[_LINES_SHOWN:]:
        found[_LINES_SHOWN:] = [Fault(more[0].file, f"so do {len(more)} more pairs of files", more[0].row)]
    faults += found


def _keys(table: ImportedTable, names: Sequence[str]) -> list[bytes]:
    """Return what two rows have in common if they are one: all numbers but that of the pose; empty if some are missing or all are zero."""
    columns = [values for name, values in sorted(table.columns.items()) if name not in ("pose", SCAN)]
    rows = np.column_stack([values.astype(float) for values in columns if values.dtype != object])
    own = np.column_stack([table.columns[name] for name in names]).astype(float)
    good = np.isfinite(own).all(axis=1) & np.any(own != 0, axis=1)
    return [row.tobytes() if whole else b"" for row, whole in zip(rows, good, strict=True)]
