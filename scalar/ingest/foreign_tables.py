"""Foreign tables as they stand: text with any separator and decimal sign, or a matrix in a MATLAB file.

Nothing is interpreted here but numbers. Every row remembers the line of the file that it comes from, so that
whatever is wrong with it later can be found with an editor; rows of a matrix count from 1. Left out:
spreadsheets (save them as CSV) and MATLAB's newer HDF5 files (save with -v7).
"""

import csv
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.regular_file import MAX_TABLE_BYTES, check_regular_file, read_regular_file
from scalar.data.located_table import MAX_COLUMNS, MAX_SHOWN, NUMBER, did_you_mean, shorten, too_many_columns
from scalar.errors import Fault, InvalidInput

Reference = str | int
"""A column of a file by its name, or by its number, the first being 1."""

_SEPARATORS = {"tab": "\t", "space": " "}
_MISSING = frozenset({"", "nan", "na", "n/a", "null"})
_LATEST_HDF5 = "a MATLAB 7.3 file, which is HDF5; save it with '-v7'"


@dataclass(frozen=True, eq=False)
class RawTable:
    """A table as its file has it.

    Attributes:
        file: name of the file.
        names: of the columns, or None where they have only numbers.
        cells: by column, ``(N,)`` each: text as objects, or float64 from a matrix.
        lines: ``(N,)`` int, the line or matrix row of each row.
        decimal: the decimal sign of text.
        missing: texts in lower case that mean that nothing was measured.
    """

    file: str
    names: tuple[str, ...] | None
    cells: tuple[np.ndarray, ...]
    lines: np.ndarray
    decimal: str = "."
    missing: frozenset[str] = _MISSING

    def find(self, reference: Reference) -> int:
        """Return the position of a column.

        Raises:
            InvalidInput: there is none of that name or number, or there are several.
        """
        if isinstance(reference, int):
            if not 1 <= reference <= len(self.cells):
                message = f"there is no column {reference}; the file has {len(self.cells)}"
                raise InvalidInput(Fault(self.file, message))
            return reference - 1
        if self.names is None:
            raise InvalidInput(
                Fault(self.file, f"its columns have no names; write a number for {reference!r}")
            )
        count = self.names.count(reference)
        if count != 1:
            named = ", ".join(repr(name) for name in dict.fromkeys(self.names))
            hint = did_you_mean(reference, list(self.names))
            what = f"{count} columns are called so; give its number" if count else f"no such column; {hint}"
            message = f"{what}the file has {shorten(named, 300)[1:-1]}" if not count else what
            raise InvalidInput(Fault(self.file, message, column=self.label(reference)))
        return self.names.index(reference)

    def label(self, reference: Reference) -> str:
        """Return what a column is called in a fault, which puts the word before it only for tables."""
        name = str(reference)
        return name if self.file.endswith((".csv", ".parquet")) else f"column {name}"

    def text(self, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
        """Return a column as text ``(N,)`` and where nothing was measured ``(N,)`` bool."""
        cells = self.cells[self.find(reference)]
        if cells.dtype != object:
            text = np.array([f"{value:.15g}" for value in cells], dtype=object)
            return text, np.isnan(cells)
        return cells, self._is_missing(cells)

    def numbers(self, reference: Reference, faults: list[Fault]) -> tuple[np.ndarray, np.ndarray]:
        """Return a column as numbers ``(N,)``, else NaN, and where nothing was measured ``(N,)`` bool.

        Text that is no number is added to `faults`.
        """
        cells = self.cells[self.find(reference)]
        if cells.dtype != object:
            return cells, np.isnan(cells)
        missing = self._is_missing(cells)
        values = np.full(len(cells), np.nan)
        wrong = []
        for i in np.flatnonzero(~missing):
            cell = cells[i]
            plain = cell.replace(",", ".") if self.decimal == "," and "." not in cell else cell
            if NUMBER.fullmatch(plain) and (self.decimal == "." or "." not in cell):
                values[i] = float(plain)
            else:
                wrong.append(i)
        other = "," if self.decimal == "." else "."
        for i in wrong[:MAX_SHOWN]:
            hint = f"the mapping says decimal: '{self.decimal}'" if other in cells[i] else "correct it"
            message = (
                f"not a number ({shorten(cells[i])}); {hint}, or add it to text.missing and use drop_without"
            )
            faults.append(Fault(self.file, message, int(self.lines[i]), self.label(reference)))
        if len(wrong) > MAX_SHOWN:
            message = f"{len(wrong) - MAX_SHOWN} more rows with the same fault; look for a common cause"
            faults.append(Fault(self.file, message, column=self.label(reference)))
        return values, missing

    def _is_missing(self, cells: np.ndarray) -> np.ndarray:
        return np.array([cell.lower() in self.missing for cell in cells], dtype=bool)


def read_raw(path: Path, text: Mapping[str, Any], variable: str | None) -> RawTable:
    """Return the table in a file: a matrix from ``.mat``, else text.

    Args:
        path: of the file.
        text: the mapping's block of that name: separator, decimal, header, skip_lines, encoding, missing.
        variable: which matrix of a ``.mat`` file; None: the only one.

    Raises:
        InvalidInput: the file cannot be read, or is not such a table; with every row at fault.
    """
    if path.suffix.lower() == ".mat":
        check_regular_file(path, MAX_TABLE_BYTES)
        return _read_matrix(path, variable)
    return _read_text(path.name, read_regular_file(path, MAX_TABLE_BYTES), text)


def _read_text(file: str, raw: bytes, text: Mapping[str, Any]) -> RawTable:
    encoding = text.get("encoding", "utf-8")
    try:
        content = raw.decode("utf-8-sig" if encoding == "utf-8" else encoding)
    except UnicodeDecodeError as error:
        row = raw.count(b"\n", 0, error.start) + 1
        message = f"byte {error.start} is not {encoding}; set text.encoding in the mapping, e.g. latin-1"
        raise InvalidInput(Fault(file, message, row)) from error
    named: str = text.get("separator", ",")
    separator = _SEPARATORS.get(named, named)
    skip = text.get("skip_lines", 0)
    try:
        rows = [(line, cells) for line, cells in _rows(content, separator) if line > skip and any(cells)]
    except csv.Error as error:
        raise InvalidInput(
            Fault(file, f"not a table of text ({error}); is it CSV, and are all quotes closed?")
        ) from error
    names = None
    if text.get("header", True) and rows:
        names = tuple(rows.pop(0)[1])
        while names and not names[-1]:  # a separator that ends every line
            names = names[:-1]
        if len(names) == 1 and any(s in names[0] for s in ",;\t|" if s != separator):
            message = f"one column only, called {shorten(names[0])}; set text.separator in the mapping"
            raise InvalidInput(Fault(file, message, skip + 1))
    if not rows:
        raise InvalidInput(Fault(file, "there are no rows of data; give a file with some"))
    width = len(names) if names is not None else len(rows[0][1])
    if width > MAX_COLUMNS:
        raise InvalidInput(Fault(file, too_many_columns(width), skip + 1))
    faults = []
    for line, cells in rows:
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) != width:
            faults.append(
                Fault(
                    file, f"{len(cells)} cells where {width} are expected; complete or remove the row", line
                )
            )
    if faults:
        raise InvalidInput(faults[:MAX_SHOWN])
    columns = []
    for j in range(width):
        column = np.empty(len(rows), dtype=object)
        column[:] = [cells[j] for _, cells in rows]
        columns.append(column)
    missing = _MISSING | {mark.strip().lower() for mark in text.get("missing", [])}
    lines = np.array([line for line, _ in rows], dtype=np.int64)
    return RawTable(file, names, tuple(columns), lines, text.get("decimal", "."), missing)


def _rows(content: str, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line on which each row begins, and its cells without the blanks around them."""
    if separator == " ":
        for line, row in enumerate(content.splitlines(), 1):
            yield line, row.split()
        return
    reader = csv.reader(
        StringIO(content, newline=""), delimiter=separator, strict=True, skipinitialspace=True
    )
    first = 1
    for cells in reader:
        yield first, [cell.strip() for cell in cells]
        first = reader.line_num + 1


def _read_matrix(path: Path, variable: str | None) -> RawTable:
    from scipy.io import loadmat

    file = path.name
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of oddities in parts of the file that are not asked for
            content = loadmat(path, appendmat=False, variable_names=None if variable is None else [variable])
    except NotImplementedError as error:
        raise InvalidInput(Fault(file, _LATEST_HDF5)) from error
    except MemoryError as error:
        raise InvalidInput(Fault(file, "claims to be larger than memory; is it damaged?")) from error
    except Exception as error:  # SciPy's reader lets through whatever a damaged file makes of it
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput(Fault(file, f"not a MATLAB file, or damaged ({shorten(reason, 80)})")) from error
    found = {name: value for name, value in content.items() if not name.startswith("__")}
    if variable is None and len(found) != 1:
        message = (
            f"holds the variables {', '.join(found) or 'none'}; name one: matrix.variable in the mapping"
        )
        raise InvalidInput(Fault(file, message))
    name = variable or next(iter(found))
    if name not in found:
        message = f"there is no variable {name!r} in it; correct matrix.variable in the mapping"
        raise InvalidInput(Fault(file, message))
    matrix = found[name]
    if not isinstance(matrix, np.ndarray) or matrix.ndim != 2 or matrix.dtype.kind not in "fiu":
        raise InvalidInput(
            Fault(file, f"the variable {name!r} is not a matrix of real numbers; name another")
        )
    if not matrix.size:
        raise InvalidInput(Fault(file, f"the matrix {name!r} has no rows; give a file with some"))
    columns = tuple(np.ascontiguousarray(column, dtype=float) for column in matrix.T)
    return RawTable(file, None, columns, np.arange(1, len(matrix) + 1))
