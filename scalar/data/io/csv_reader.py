"""Read CSV files: by a fast parser, or cell by cell.

The fast parser takes a whole file at once. Only if it fails is the file read again cell by cell, to find
every fault and its row, or to accept what the fast parser does not (``+1.5``).
"""

from __future__ import annotations

import csv
import re
from array import array
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.io.cells import CellsOfNumbers, CellsOfText, text_column
from scalar.data.io.grouped_digits import remedy_of_groups
from scalar.data.io.regular_file import MAX_TABLE_BYTES, read_regular_file
from scalar.data.io.semicolons import with_commas
from scalar.data.io.uneven_rows import faults_of_rows
from scalar.data.located_table import (
    DIRECTIONS,
    HEADER_AGAIN,
    Layout,
    Table,
    check_cells,
    did_you_mean,
    header_faults,
    shorten,
)
from scalar.errors import Fault, InvalidInput

if TYPE_CHECKING:
    import pyarrow as pa

_SPREADSHEET = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # how files of Excel and LibreOffice begin, new and old
_LINE_END = re.compile(r"\r\n|\r|\n")
_DIGIT_AT_THE_START = re.compile(r"[-+.,]*[0-9]")


def read_csv(path: Path, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table in a CSV file, None if nothing of it can be used; faults are added to `faults`."""
    file = path.name
    try:
        raw = read_regular_file(path, MAX_TABLE_BYTES)
    except InvalidInput as error:
        faults += error.faults
        return None
    if layout.semicolons:
        raw = with_commas(raw)
    names = _plain_header(raw)
    if names is not None and not header_faults(file, names, layout):
        parsed = _parse_fast(raw, names, layout)
        if parsed is not None:
            table = Table(file, parsed, lambda: _line_numbers(raw))
            check_cells(table, layout, faults)
            return table
    return _read_by_cell(file, raw, layout, faults)


def _plain_header(raw: bytes) -> list[str] | None:
    """Return the names in the first line, None if the fast parser cannot be used."""
    line = raw.split(b"\n", 1)[0].removesuffix(b"\r")
    if not line.strip() or b"\r" in line:
        return None
    try:
        return split(line.decode("utf-8-sig"))
    except UnicodeDecodeError:
        return None


def _parse_fast(raw: bytes, names: list[str], layout: Layout) -> dict[str, np.ndarray] | None:
    """Return the columns of a CSV file parsed in C, or None if any cell is not what it should be."""
    import pyarrow as pa
    import pyarrow.csv as pa_csv

    types = {name: pa.string() if name in layout.text else pa.float64() for name in names}
    try:
        table = pa_csv.read_csv(
            pa.BufferReader(_copied_by_arrow(raw)),
            read_options=pa_csv.ReadOptions(column_names=names, skip_rows=1),
            convert_options=pa_csv.ConvertOptions(
                column_types=types, null_values=[], strings_can_be_null=False
            ),
        )
    except pa.ArrowException:
        return None
    return {
        name: text_column(table[name].to_pylist())
        if name in layout.text
        else np.array(np.from_dlpack(table[name].combine_chunks()))  # not to_numpy: that imports pandas
        for name in names
    }


def _copied_by_arrow(raw: bytes) -> pa.Buffer:
    """Return the bytes in memory of Arrow's own.

    A thread of Arrow may release its input after the call has returned. To release memory of Python it has to wait for the interpreter, and if
    that ends meanwhile, the whole process is aborted (exit status 134) although all its work is done.
    """
    import pyarrow as pa

    stream = pa.BufferOutputStream()
    stream.write(raw)
    return stream.getvalue()


def _line_numbers(raw: bytes) -> np.ndarray:
    """Return the line of every row, blank lines counted."""
    lines = _LINE_END.split(raw.decode("utf-8", "replace"))
    return np.array([i for i, line in enumerate(lines, 1) if line.strip()][1:], dtype=np.int64)


def split(line: str) -> list[str] | None:
    """Return the cells of one line, without the blanks around them; None if the quotes do not match."""
    if '"' not in line:
        return [cell.strip() for cell in line.split(",")]
    try:
        return [cell.strip() for cell in next(csv.reader([line], strict=True, skipinitialspace=True), [])]
    except csv.Error:
        return None


def _read_by_cell(file: str, raw: bytes, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table in a CSV file, read cell by cell, and add every fault with its row."""
    if (text := _decoded(file, raw, faults)) is None:
        return None
    if (names := _header(file, text, layout, faults)) is None:
        return None
    columns = [_column(name, layout) for name in names]
    numbers, whole = _read_rows(file, text, names, columns, faults)
    table = Table(file, {}, lambda: np.array(numbers, dtype=np.int64), whole=whole)
    for name, column in zip(names, columns, strict=True):
        if not name or names.count(name) > 1:
            continue
        if isinstance(column, CellsOfText):
            table.columns[name] = column.array() if name in layout.text else column.numbers_or_text()
            continue
        table.columns[name] = column.array()
        _check_numeric_cells(table, name, column.others, layout, faults)
    check_cells(table, layout, faults)
    return table


def _decoded(file: str, raw: bytes, faults: list[Fault]) -> str | None:
    """Return the text of a file; None, with the fault, if it is not UTF-8."""
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if raw.startswith(_SPREADSHEET):
            message = (
                "this is a spreadsheet and no text; save it as CSV (UTF-8), or read it with `scalar import`"
            )
            faults.append(Fault(file, message))
            return None
        row = len(_LINE_END.split(raw[: error.start].decode("utf-8", "replace")))
        faults.append(Fault(file, f"byte {error.start} is not UTF-8; save the file as UTF-8 text", row))
        return None


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text that are not blank, each with its number, one at a time: all of them take several times the memory of the text."""
    start, number = 0, 1
    for end in _LINE_END.finditer(text):
        if (line := text[start : end.start()]).strip():
            yield number, line
        start, number = end.end(), number + 1
    if (line := text[start:]).strip():
        yield number, line


def _header(file: str, text: str, layout: Layout, faults: list[Fault]) -> list[str] | None:
    """Return the names of the columns; None, with the fault, if the file is empty, has comments, or its columns cannot be distinguished.

    Args:
        file: Name of the file.
        text: Its content.
        layout: The columns that it may have.
        faults: Faults of names are added here as well.
    """
    first = next(_lines(text), None)
    if first is None:
        faults.append(Fault(file, f"the file is empty; its first line has to be {','.join(layout.required)}"))
        return None
    comments = [number for number, line in _lines(text) if line.lstrip().startswith("#")]
    if comments and comments[0] == first[0] and _is_header(first[1].lstrip("# "), layout):
        faults.append(Fault(file, "the header begins with #; remove this character", comments[0]))
        return None
    if comments:
        more = f", and {len(comments) - 1} more" if len(comments) > 1 else ""
        message = f"a line that begins with #{more}: a table has no comments; remove such lines"
        faults.append(Fault(file, message, comments[0]))
        return None
    names = split(first[1])
    if names is None:
        faults.append(Fault(file, "a quote in the header is not closed; close or remove it", first[0]))
        return None
    wrong = header_faults(file, names, layout, first[0])
    faults += wrong
    return None if len(wrong) == 1 and wrong[0].column is None else names


def _column(name: str, layout: Layout) -> CellsOfNumbers | CellsOfText:
    """Return what collects the cells of a column: text where the layout says so, or where a column that it does not know is copied as it is."""
    known = name in layout.required or name in layout.optional
    return CellsOfText() if name in layout.text or (layout.copied and not known) else CellsOfNumbers()


def _read_rows(
    file: str,
    text: str,
    names: Sequence[str],
    columns: Sequence[CellsOfNumbers | CellsOfText],
    faults: list[Fault],
) -> tuple[array[int], bool]:
    """Add the cells of the rows that have as many as there are columns to these; faults of the others are added.

    Returns:
        The numbers of the lines that were taken, and whether all were.
    """
    numbers, wrong, uneven = array("q"), [], []
    width = len(columns)
    for number, line in islice(_lines(text), 1, None):
        cells = split(line)
        if cells is None:
            wrong.append((number, "a quote is not closed; close or remove it"))
        elif not any(cells):
            continue  # a blank line too, as spreadsheets save it
        elif cells == names:
            wrong.append((number, HEADER_AGAIN))
        elif len(cells) != width:
            uneven.append(cells)
            message = f"{len(cells)} cells where the header names {width}; complete or remove the row"
            wrong.append((number, message))
        else:
            for column, cell in zip(columns, cells, strict=True):
                column.append(cell)
            numbers.append(number)
    faults += faults_of_rows(file, wrong, () if numbers else uneven, width)
    return numbers, not wrong


def _is_header(line: str, layout: Layout) -> bool:
    """Return whether a line names all columns that the layout requires."""
    return {*(split(line) or ())} >= {*layout.required}


def _check_numeric_cells(
    table: Table, name: str, others: Mapping[int, str], layout: Layout, faults: list[Fault]
) -> None:
    """Report the cells of a numeric column that are not numbers, which ``others`` has by their row."""
    count = table.n_rows
    cells = {i: cell for i, cell in others.items() if cell or name not in layout.blank}
    wrong = np.zeros(count, dtype=bool)
    wrong[list(cells)] = True
    known = [*layout.required, *layout.optional]
    if name not in known and 2 * len(cells) > count:
        text = shorten(cells[int(np.argmax(wrong))])
        hint = did_you_mean(name, known)
        message = f"an unknown column, and not of numbers ({text}); {hint}rename or remove it"
        faults.append(Fault(table.file, message, 1, name))
        table.bad[name] = np.ones(count, dtype=bool)
        return

    filled = np.zeros(count, dtype=bool)
    filled[[i for i, cell in cells.items() if cell]] = True
    if name in layout.integers and 2 * np.count_nonzero(filled) > count:
        table.report(faults, name, (np.cumsum(filled) == 1) & filled, lambda i: _labels(cells[i]))
        table.bad[name] |= filled

    def message_of(i: int) -> str:
        if not cells[i]:
            return "an empty cell; write the number, or remove the row"
        if name in layout.integers and not _DIGIT_AT_THE_START.match(cells[i]):
            return f"not a whole number ({shorten(cells[i])}); write one that no other pose has"
        hint = "write a decimal point, as in 0.123" if "," in cells[i] else "write it as 0.123"
        hint = remedy_of_groups(cells[i]) or hint
        if cells[i][0] in "\u2012\u2013\u2014\u2212":
            hint = f"its minus is another character (a dash): write - of the keyboard{', and a decimal point' if ',' in cells[i] else ''}"
        if name.startswith("approach"):
            hint = DIRECTIONS
        if ":" in cells[i] and name == "time":
            hint = "write seconds from any moment on, or read the table with `scalar import`, which takes times of day"
        return f"not a number ({shorten(cells[i])}); {hint}"

    table.report(faults, name, wrong, message_of)


def _labels(cell: str) -> str:
    """Return the message about a column of whole numbers that holds names instead."""
    return (
        f"names such as {shorten(cell)}, and whole numbers are needed; number the rows that belong together 1, 2, 3 ..., "
        "with the same numbers in all tables"
    )
