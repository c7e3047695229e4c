"""Rows of text become a table: which of them names the columns, which state units or are remarks, and whether all have the same number of cells."""

import re
import unicodedata
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from scalar.data.located_table import MAX_SHOWN, shorten, too_many_columns
from scalar.errors import Fault, InvalidInput
from scalar.ingest.raw_table import MISSING, MOST_COLUMNS, RawTable
from scalar.ingest.written_numbers import Written, is_row_of_units

# If this share of the rows has the same number of cells, and the first row has fewer, the first row is a title and not a header.
_MOST_ROWS = 0.8


def table_of_rows(
    file: str, rows: list[tuple[int, list[str]]], text: Mapping[str, Any], separator: str | None = None
) -> RawTable:
    """Return the table of rows of text, the first of which may name the columns.

    Args:
        file: name of the file.
        rows: the cells of each row, with the number of its line.
        text: the block ``text`` of the mapping.
        separator: the separator between cells; None for a file without separators.

    Raises:
        InvalidInput: there is no row, or rows differ in length.
    """
    skip = text.get("skip_lines", 0)
    comment = text.get("comment")
    rows = [
        (line, cells)
        for line, cells in rows
        if line > skip and any(cells) and not (comment and cells[0].startswith(comment))
    ]
    names, first = None, rows[0][0] if rows else skip + 1
    if text.get("header", True) and rows:
        # The same letter may be written as one sign, or as a letter and its dots (macOS).
        names = tuple(unicodedata.normalize("NFC", cell) for cell in rows.pop(0)[1])
        while names and not names[-1]:  # every line ends with a separator
            names = names[:-1]
        if separator and len(names) == 1 and any(s in names[0] for s in ",;\t|" if s != separator):
            message = f"one column only, called {shorten(names[0])}; set text.separator in the mapping"
            raise InvalidInput(Fault(file, message, first))
    if not rows:
        raise InvalidInput(Fault(file, "there are no rows of data; give a file with some"))
    written = Written(text.get("decimal", "."), text.get("thousands", ""))
    missing = MISSING | {mark.strip().lower() for mark in text.get("missing", [])}
    if names is not None and len(rows) > 1 and is_row_of_units(rows[0][1], rows[1][1], written, missing):
        rows.pop(0)
    width = len(names) if names is not None else len(rows[0][1])
    if width > MOST_COLUMNS:
        raise InvalidInput(Fault(file, too_many_columns(width, MOST_COLUMNS), first))
    _check_widths(
        file, rows, width, written, named=names is not None, first=first, commas=separator == written.decimal
    )
    columns = []
    for j in range(width):
        column = np.empty(len(rows), dtype=object)
        column[:] = [cells[j] for _, cells in rows]
        columns.append(column)
    lines = np.array([line for line, _ in rows], dtype=np.int64)
    return RawTable(file, names, tuple(columns), lines, written, missing)


def _check_widths(
    file: str,
    rows: list[tuple[int, list[str]]],
    width: int,
    written: Written,
    *,
    named: bool,
    first: int,
    commas: bool,
) -> None:
    """Refuse rows that have not ``width`` cells; empty cells beyond are removed from ``rows``.

    Args:
        file: name of the file.
        rows: the cells of each row of data, with the number of its line.
        width: number of the columns.
        written: how the file writes numbers.
        named: whether a row names the columns.
        first: number of the line of that row.
        commas: whether the decimal sign also separates the cells.

    Raises:
        InvalidInput: a row has more or fewer cells.
    """
    faults = []
    for line, cells in rows:
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) != width:
            what = f"{len(cells)} cell{'s' if len(cells) > 1 else ''} where {width} are expected"
            faults.append(Fault(file, f"{what}; {_remedy(cells)}", line))
    if not faults:
        return
    if commas:
        message = (
            f"{len(faults)} rows have other numbers of cells than the first: where a comma separates the cells and is the decimal sign, numbers "
            "have to stand in quotes; set text.separator in the mapping to the sign between the cells, or quote them"
        )
        raise InvalidInput(Fault(file, message, faults[0].row))
    usual, times = Counter(len(cells) for _, cells in rows).most_common(1)[0]
    if named and width < usual and times > _MOST_ROWS * len(rows):
        begin = _line_of_names(rows, usual, written)
        numbers = [
            written.number(cell) is not None for line, cells in rows if line == begin for cell in cells
        ]
        nameless = (
            f", and header: false, since line {begin} holds numbers and no names"
            if sum(numbers) > len(numbers) / 2
            else ""
        )
        message = (
            f"the line that should name the columns has {width} cell{'s' if width > 1 else ''}, and {times} of the {len(rows)} lines after it "
            f"have {usual}; if a title stands before the table, write skip_lines: {begin - 1} under text in the mapping{nameless}"
        )
        raise InvalidInput(Fault(file, message, first))
    raise InvalidInput(faults[:MAX_SHOWN])


def _line_of_names(rows: list[tuple[int, list[str]]], width: int, written: Written) -> int:
    """Return the line that names the columns below a title: the last one with ``width`` cells before the first that holds nothing but numbers.

    The state of an instrument may have as many cells as the table has columns.
    """
    wide = [(line, cells) for line, cells in rows if len(cells) == width]
    n_numbers = [sum(written.number(cell) is not None for cell in cells) for _, cells in wide]
    full = [sum(map(bool, cells)) for _, cells in wide]
    data = next((i for i, n in enumerate(n_numbers) if 0 < n == full[i]), 0)
    if (
        data > 1
        and n_numbers[data - 2] == 0
        and is_row_of_units(wide[data - 1][1], wide[data][1], written, frozenset())
    ):
        return wide[data - 2][0]
    return wide[max(data - 1, 0)][0]


def _remedy(cells: list[str]) -> str:
    """Return what to do about a row with a wrong number of cells."""
    mark = re.match(r"[#;%!*]|//|--", cells[0])
    if mark is None:
        return "complete or remove the row"
    return f"if it is a remark, write comment: '{mark[0]}' under text in the mapping, and lines that begin so are passed over"
