"""Spreadsheets (.xlsx, .xlsm) as foreign tables: the values in the cells, for formulas the value that was last computed.

A number that stands in a cell as text is read as the mapping says that numbers are written; all others are numbers already.
"""

# pyright: reportMissingTypeStubs=false, reportMissingModuleSource=false

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from typing import Any

from scalar.data.located_table import did_you_mean, shorten
from scalar.errors import Fault, InvalidInput
from scalar.ingest.raw_table import MISSING, RawTable
from scalar.ingest.rows_of_text import table_of_rows
from scalar.ingest.written_numbers import Written

_MOST_ROWS = 1_048_576
"""Of a sheet in this format; the library makes up every row before one with a higher number."""


def read_spreadsheet(file: str, raw: bytes, text: Mapping[str, Any]) -> RawTable:
    """Return the table on a sheet of a spreadsheet; rows have the numbers that the spreadsheet shows.

    Args:
        file: name of the file.
        raw: its content.
        text: the block ``text`` of the mapping: sheet (the first if not named), header, skip_lines, missing.

    Raises:
        InvalidInput: it is no spreadsheet, lacks the sheet, or the sheet holds no table.
    """
    from openpyxl import load_workbook

    try:
        book = load_workbook(BytesIO(raw), read_only=True, data_only=True)
        names = list(book.sheetnames)
        wanted = text.get("sheet", names[0])
        if wanted not in names:
            hint = did_you_mean(wanted, names)
            message = f"no sheet {shorten(wanted)}; {hint}it has {', '.join(names)}; correct text.sheet"
            raise InvalidInput(Fault(file, message))
        sheet = book[wanted]
        sheet.reset_dimensions()  # what the file says of its size may be wrong, and every row would be filled up to it
        written = Written(text.get("decimal", "."), text.get("thousands", ""))
        marks = MISSING | {mark.strip().lower() for mark in text.get("missing", [])}
        rows = []
        for line, cells in enumerate(sheet.iter_rows(values_only=True), 1):
            if line > _MOST_ROWS:
                message = f"has a row beyond {_MOST_ROWS}, the last that a spreadsheet can have; save it again, or as CSV"
                raise InvalidInput(Fault(file, message))
            if cells:
                rows.append((line, [_cell(value, written, marks) for value in cells]))
    except InvalidInput:
        raise
    except Exception as error:  # whatever the library raises on a damaged file is a fault of that file
        reason = " ".join(str(error).split()) or type(error).__name__
        message = f"not a spreadsheet, or damaged ({shorten(reason, 80)}); save it as .xlsx, or as CSV"
        raise InvalidInput(Fault(file, message)) from error
    others = [name for name in names if name != wanted]
    if others and sum(any(cells) for _, cells in rows) < 2:
        message = f"the sheet {shorten(wanted)} holds no table; there is also {', '.join(others)}: name the sheet that is meant as text.sheet"
        raise InvalidInput(Fault(file, message))
    width = max((k + 1 for _, cells in rows for k, cell in enumerate(cells) if cell), default=0)
    blank = [""] * width
    return table_of_rows(
        file,
        [(line, (cells + blank)[:width]) for line, cells in rows],
        {**text, "decimal": ".", "thousands": ""},
    )


def _cell(value: Any, written: Written, marks: frozenset[str]) -> str:
    """Return a cell as text; numbers to the last digit, with a decimal point. Marks for "not measured" stay as they are."""
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    cell = str(value).strip()
    if written == Written() or not isinstance(value, str) or cell.lower() in marks:
        return cell
    number = written.number(cell)
    # What is the same number in either way of writing, as 17, stays as it is: it may name a column, a session or a pose.
    return cell if number is None or number == Written().number(cell) else repr(number)
