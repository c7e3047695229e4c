"""Tables whose cells are separated by semicolons, as spreadsheets write them where numbers have a decimal comma.

Only tables that a person keeps beside a dataset are read so: poses to predict or to correct, DH tables. The files of a dataset have commas and
decimal points. A decimal comma is taken for one only where no cell of the table has a decimal point: ``1,234`` may be a thousand where points are
decimal.
"""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scalar.data.io.regular_file import MAX_TABLE_BYTES, read_regular_file
from scalar.data.located_table import NUMBER

if TYPE_CHECKING:
    import pandas as pd

_LINE_END = re.compile(rb"(\r\n|\r|\n)")
_DECIMAL_COMMA = re.compile(r"[-+]?([0-9]+,[0-9]*|,[0-9]+)([eE][-+]?[0-9]+)?")
_BOM = b"\xef\xbb\xbf"


@dataclass(frozen=True)
class TextForm:
    """How the cells of a table are separated, and how its numbers are written.

    Attributes:
        separator: Between two cells of a row.
        decimal: Before the decimals of a number.
    """

    separator: str = ","
    decimal: str = "."

    @property
    def in_words(self) -> str:
        """A clause that ends a line, such as ``, with semicolons and decimal commas``; empty for commas and decimal points."""
        if self.separator == ",":
            return ""
        return f", with semicolons and decimal {'commas' if self.decimal == ',' else 'points'} as in the table that was read"

    def write(self, table: pd.DataFrame, path: Path, number: str) -> None:
        """Write a table so, without its index; numbers by a format such as ``%.12g``."""

        def cell_of(value: object) -> object:
            return (number % value).replace(".", self.decimal) if isinstance(value, float) else value

        if self.decimal != ".":  # of a column that holds texts too, pandas leaves the decimal points
            table = table.copy()
            for name in table.columns:
                if table[name].dtype.kind == "O":
                    table[name] = table[name].map(cell_of)
        table.to_csv(path, index=False, float_format=number, sep=self.separator, decimal=self.decimal)


PLAIN = TextForm()


def form_of(raw: bytes) -> TextForm:
    """Return how a table is written: with semicolons if its header has more of them than commas, and decimal commas if no number has a point."""
    header = _LINE_END.split(raw.removeprefix(_BOM).lstrip(), maxsplit=1)[0]
    if header.count(b";") <= header.count(b","):
        return PLAIN
    for line in _LINE_END.split(raw)[::2]:
        for cell in _cells(line) or ():
            if "." in cell and NUMBER.fullmatch(cell):
                return TextForm(";", ".")
    return TextForm(";", ",")


def with_commas(raw: bytes) -> bytes:
    """Return a table with commas between its cells and decimal points, line by line; as it is if it has no semicolons between its cells."""
    form = form_of(raw)
    if form == PLAIN:
        return raw
    parts = _LINE_END.split(raw.removeprefix(_BOM))
    parts[::2] = [_line_with_commas(line, form) for line in parts[::2]]
    return b"".join(parts)


def form_of_file(path: Path) -> TextForm:
    """Return how the table in a file is written.

    Raises:
        InvalidInput: The file cannot be read.
    """
    return form_of(read_regular_file(path, MAX_TABLE_BYTES))


def text_with_commas(path: Path) -> str:
    """Return the text of a CSV file with commas between its cells and decimal points, a line for each of its lines.

    Raises:
        InvalidInput: The file cannot be read.
    """
    return with_commas(read_regular_file(path, MAX_TABLE_BYTES)).decode("utf-8-sig", "replace")


def cells_as_written(path: Path) -> dict[str, list[str]]:
    """Return the cells of each column of a CSV file that has been read without a fault, row by row, without the blanks around them."""
    raw = read_regular_file(path, MAX_TABLE_BYTES)
    separator = form_of(raw).separator
    lines = [line for line in _LINE_END.split(raw.removeprefix(_BOM))[::2] if line.strip()]
    rows = [_cells(line, separator) or [] for line in lines]
    return {name: list(cells) for name, *cells in zip(*rows, strict=True)}


def _line_with_commas(line: bytes, form: TextForm) -> bytes:
    """Return one line with commas between its cells; as it is if it is empty or a quote in it is not closed."""
    if not line.strip() or (cells := _cells(line)) is None:
        return line
    if form.decimal == ",":
        cells = [cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
    out = io.StringIO()
    csv.writer(out, lineterminator="").writerow(cells)
    return out.getvalue().encode("utf-8", "surrogateescape")


def _cells(line: bytes, separator: str = ";") -> list[str] | None:
    """Return the cells of one line, without the blanks around them; None if a quote is not closed."""
    text = line.decode("utf-8", "surrogateescape")
    if '"' not in text:
        return [cell.strip() for cell in text.split(separator)]
    try:
        rows = csv.reader([text], delimiter=separator, strict=True, skipinitialspace=True)
        return [cell.strip() for cell in next(rows, [])]
    except csv.Error:
        return None
