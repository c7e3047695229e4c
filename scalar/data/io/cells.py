"""The cells of one column while a table is read cell by cell: numbers as float64 from the start, text as it is.

A table of points has millions of cells, and each takes ten times the memory as text.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from scalar.data.located_table import NUMBER

_NOT_FINITE = re.compile(r"[-+]?(nan|inf|infinity)", re.IGNORECASE)


@dataclass
class CellsOfNumbers:
    """A column of numbers.

    Attributes:
        values: The number in each cell; NaN where it holds something else.
        others: The cells that hold something else, by their row, from 0.
    """

    values: array[float] = field(default_factory=lambda: array("d"))
    others: dict[int, str] = field(default_factory=dict[int, str])

    def append(self, cell: str) -> None:
        """Add the cell of the next row."""
        if NUMBER.fullmatch(cell) or _NOT_FINITE.fullmatch(cell):
            self.values.append(float(cell))
        else:
            self.others[len(self.values)] = cell
            self.values.append(np.nan)

    def array(self) -> np.ndarray:
        """Return the numbers, ``(N,)`` float64."""
        return np.array(self.values, dtype=float)


@dataclass
class CellsOfText:
    """A column of text, or one of which nobody knows yet what it is.

    Attributes:
        cells: Each cell as it stands there.
    """

    cells: list[str] = field(default_factory=list[str])

    def append(self, cell: str) -> None:
        """Add the cell of the next row."""
        self.cells.append(cell)

    def array(self) -> np.ndarray:
        """Return the text, ``(N,)`` of objects, without the blanks around it."""
        return text_column(self.cells)

    def numbers_or_text(self) -> np.ndarray:
        """Return numbers, ``(N,)`` float64, if every cell is one, else the text."""
        if all(map(NUMBER.fullmatch, self.cells)):
            return np.array([float(cell) for cell in self.cells], dtype=float)
        return self.array()


def text_column(cells: Sequence[str]) -> np.ndarray:
    """Return text as an array of objects ``(N,)``, without the blanks around it."""
    column = np.empty(len(cells), dtype=object)
    column[:] = [cell.strip() for cell in cells]
    return column
