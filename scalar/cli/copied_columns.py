"""The cells of a table as they are written in its file, for columns that are copied and not read."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path


def cells_as_written(path: Path, columns: Sequence[str]) -> dict[str, list[str]]:
    """Return the cells of each column of a CSV file that has been read without a fault, row by row, without the blanks around them.

    Args:
        path: The file.
        columns: The names of all its columns.
    """
    with path.open(encoding="utf-8-sig", newline="") as text:
        reader = csv.reader(text, skipinitialspace=True)
        next(reader)
        rows = [[cell.strip() for cell in cells] for cells in reader if any(cell.strip() for cell in cells)]
    return {name: [cells[i] for cells in rows] for i, name in enumerate(columns)}
