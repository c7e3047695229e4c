"""Read foreign tables: text with any separator and decimal sign, a spreadsheet, a matrix in a MATLAB file, records in YAML, a scanner's profile.

Every row keeps the number of its line in the file, by which the message about a fault names it; the rows of a matrix are numbered from 1.
MATLAB's newer HDF5 files (save with -v7 instead) and spreadsheets older than .xlsx are not read.
"""

import csv
import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.regular_file import MAX_TABLE_BYTES, check_regular_file, read_regular_file
from scalar.data.located_table import shorten
from scalar.errors import Fault, InvalidInput
from scalar.ingest.profile_files import is_gocator, is_opencv, read_gocator, read_opencv
from scalar.ingest.raw_table import RawTable, last_number
from scalar.ingest.records import read_records
from scalar.ingest.rows_of_text import table_of_rows
from scalar.ingest.spreadsheet import read_spreadsheet

_SEPARATORS = {
    "tab": "\t",
    r"\t": "\t",
    "space": " ",
}  # in single quotes, YAML leaves the two characters of \t as they are
_IS_ZIP, _IS_OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"  # how spreadsheets begin, whatever their names end in
_IS_HDF5 = "a MATLAB 7.3 file, which is HDF5; save it with '-v7'"


def read_raw(path: Path, text: Mapping[str, Any], variable: str | None, file: str | None = None) -> RawTable:
    """Return the table in a file: a matrix from ``.mat``, a sheet from ``.xlsx``, records or a profile from ``.yml``, Gocator's CSV, else text.

    Args:
        path: the file.
        text: the block ``text`` of the mapping: separator, decimal, thousands, header, skip_lines, encoding, missing, sheet, dates.
        variable: name of the matrix in a ``.mat`` file; None for the only one.
        file: what messages call the file; if None, its name.

    Raises:
        InvalidInput: the file cannot be read, or is not such a table; every faulty row is named.
    """
    return replace(
        _read(path, file or path.name, text, variable), number=last_number(path.stem), dates=text.get("dates")
    )


def _read(path: Path, file: str, text: Mapping[str, Any], variable: str | None) -> RawTable:
    """Return the table in a file, read in the form that its name or its first bytes show."""
    kind = path.suffix.lower()
    if kind == ".mat":
        check_regular_file(path, MAX_TABLE_BYTES, file)
        return _read_matrix(path, file, variable)
    raw = read_regular_file(path, MAX_TABLE_BYTES, file)
    if raw.startswith(_IS_OLE):
        message = "an Excel file of the form before 2007, which is not read; save it as .xlsx, or as CSV"
        raise InvalidInput(Fault(file, message))
    if kind in (".xlsx", ".xlsm") or raw.startswith(_IS_ZIP):
        return read_spreadsheet(file, raw, text)
    if kind in (".yml", ".yaml"):
        return read_opencv(file, raw) if is_opencv(raw) else read_records(file, raw, text.get("missing", []))
    return read_gocator(file, raw) if is_gocator(raw) else _read_text(file, raw, text)


def _read_text(file: str, raw: bytes, text: Mapping[str, Any]) -> RawTable:
    """Return the table in a text file; ``text`` is the block of that name in the mapping."""
    encoding = text.get("encoding", "utf-8")
    try:
        content = raw.decode("utf-8-sig" if encoding == "utf-8" else encoding)
    except UnicodeDecodeError as error:
        row = raw.count(b"\n", 0, error.start) + 1
        guess = " to utf-16" if raw.startswith((b"\xff\xfe", b"\xfe\xff")) else ", e.g. latin-1"
        message = f"byte {error.start} is not {encoding}; set text.encoding in the mapping{guess}"
        raise InvalidInput(Fault(file, message, row)) from error
    named: str = text.get("separator", ",")
    separator = _SEPARATORS.get(named, named)
    try:
        rows = list(_rows(content, separator))
    except csv.Error as error:
        raise InvalidInput(
            Fault(file, f"not a table of text ({error}); is it CSV, and are all quotes closed?")
        ) from error
    return table_of_rows(file, rows, text, separator)


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


def _read_matrix(path: Path, file: str, variable: str | None) -> RawTable:
    """Return the matrix in a MATLAB file; ``variable`` names it, or is None if the file has a single one."""
    from scipy.io import loadmat, whosmat

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about parts of the file that are not read
            held = whosmat(path, appendmat=False)
            size = sum(8 * math.prod(shape) for name, shape, _ in held if variable in (None, name))
            if size > MAX_TABLE_BYTES:  # compressed, zeros without end are a small file
                message = f"holds a matrix of {size / 1e6:.0f} MB, more than the {MAX_TABLE_BYTES // 1_000_000} MB that are read; make it shorter"
                raise InvalidInput(Fault(file, message))
            content = loadmat(path, appendmat=False, variable_names=None if variable is None else [variable])
    except InvalidInput:
        raise
    except NotImplementedError as error:
        raise InvalidInput(Fault(file, _IS_HDF5)) from error
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
