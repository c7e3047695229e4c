"""Tables of numbers out of CSV and Parquet files, and the row and column of everything that is wrong in them.

The fast way parses a whole file in C and checks whole columns at once. Only where that fails is the file read
again cell by cell, to find every fault and its row, or to accept what the fast way is too strict for (``+1.5``).
A row is the line that a text editor shows, the header being line 1; rows of a Parquet file count from 1.
"""

import csv
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq

from scalar.errors import Fault

MAX_SHOWN = 100
"""Faults of one kind in one column that are written out; a last line counts the others."""
MAX_INTEGER = 2.0**53  # the largest up to which float64 holds every integer

_LINE_END = re.compile(r"\r\n|\r|\n")
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?(nan|inf|infinity)", re.IGNORECASE)


@dataclass(frozen=True)
class Layout:
    """Which columns a table may have.

    Attributes:
        required: columns that have to be there.
        optional: columns that are known and may be there.
        text: those of them that hold text; all others hold numbers.
        integers: those that hold integers.
        extras: whether further numeric columns are kept.
        refuse: returns what is wrong with a column of that name, or None.
    """

    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    text: frozenset[str] = frozenset()
    integers: frozenset[str] = frozenset({"pose"})
    extras: bool = False
    refuse: Callable[[str], str | None] = lambda _: None


@dataclass
class Table:
    """The columns of one file; float64 or text (object), each of the same length.

    Attributes:
        file: name of the file.
        columns: by name, in the order of the file; float64 ``(N,)``, or text as objects.
        bad: for each column the cells that have been reported already, ``(N,)`` bool.
        whole: False where rows had to be left out, so that nothing may be concluded from what is missing.
    """

    file: str
    columns: dict[str, np.ndarray]
    line_numbers: Callable[[], np.ndarray]
    whole: bool = True
    bad: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def n_rows(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.columns.values()))) if self.columns else 0

    def good(self, *names: str) -> bool:
        """Return whether these columns are all there and hold no faulty cell."""
        return all(name in self.columns and not np.any(self.bad.get(name, False)) for name in names)

    def report(self, faults: list[Fault], column: str, mask: np.ndarray, message: Callable[[int], str]) -> None:
        """Add a fault for every row of `mask` that was not reported for this column before."""
        bad = self.bad.setdefault(column, np.zeros(self.n_rows, dtype=bool))
        rows = np.flatnonzero(mask & ~bad)
        if not rows.size:
            return
        bad[rows] = True
        lines = self.line_numbers()
        faults += [Fault(self.file, message(int(i)), int(lines[i]), column) for i in rows[:MAX_SHOWN]]
        if rows.size > MAX_SHOWN:
            more = f"{rows.size - MAX_SHOWN} more rows with the same fault, the last in row {lines[rows[-1]]}"
            faults.append(Fault(self.file, f"{more}; look for a common cause", column=column))


def did_you_mean(name: str, known: list[str]) -> str:
    """Return ``did you mean 'noise'? `` where a known name is like `name`, else nothing."""
    by_lower = {candidate.lower(): candidate for candidate in reversed(known)}
    close = get_close_matches(name.lower(), list(by_lower), n=1, cutoff=0.6)
    return f"did you mean {by_lower[close[0]]!r}? " if close else ""


def shorten(value: object, width: int = 40) -> str:
    """Return how `value` is written, cut to `width` characters."""
    text = repr(value)
    return text if len(text) <= width else text[: width - 4] + "..." + text[-1]


def read_csv(path: Path, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table in a CSV file, None if nothing of it can be used; faults are added to `faults`."""
    file = path.name
    try:
        raw = path.read_bytes()
    except OSError as error:
        faults.append(Fault(file, f"cannot be read ({error.strerror or error}); check the file and its permissions"))
        return None
    head = raw.split(b"\n", 1)[0]
    names = _split(head.decode("utf-8-sig", "replace").removesuffix("\r"))
    plain_head = names is not None and b"\r" not in head[:-1] and head.strip() and b"\xff" not in head
    if plain_head and names is not None and _well_named(names, layout):
        text = {name: name in layout.text for name in names}
        table = _parse_fast(raw, text)
        if table is not None:
            columns = {
                name: _text([str(x) for x in table[name].to_pylist()]) if text[name] else table[name].to_numpy()
                for name in names
            }
            found = Table(file, columns, lambda: _line_numbers(raw, table.num_rows))
            _check_cells(found, layout, faults)
            return found
    return _read_csv_by_cell(file, raw, layout, faults)


def _parse_fast(raw: bytes, text: dict[str, bool]) -> pa.Table | None:
    """Return the body of a CSV file parsed in C, or None if any cell is not what it should be."""
    types = {name: pa.string() if is_text else pa.float64() for name, is_text in text.items()}
    try:
        return pa_csv.read_csv(
            pa.BufferReader(raw),
            read_options=pa_csv.ReadOptions(column_names=list(text), skip_rows=1),
            convert_options=pa_csv.ConvertOptions(column_types=types, null_values=[], strings_can_be_null=False),
        )
    except (pa.ArrowException, UnicodeDecodeError):
        return None


def _line_numbers(raw: bytes, n_rows: int) -> np.ndarray:
    """Return the line of every row, blank lines counted."""
    lines = _LINE_END.split(raw.decode("utf-8", "replace"))
    numbers = np.array([i for i, line in enumerate(lines, 1) if line.strip()][1:], dtype=np.int64)
    return numbers if len(numbers) == n_rows else np.arange(2, n_rows + 2)


def _split(line: str) -> list[str] | None:
    """Return the cells of one line, without the blanks around them; None if the quotes do not match."""
    if '"' not in line:
        return [cell.strip() for cell in line.split(",")]
    try:
        return [cell.strip() for cell in next(csv.reader([line], strict=True, skipinitialspace=True), [])]
    except csv.Error:
        return None


def _well_named(names: list[str], layout: Layout) -> bool:
    return not _header_faults("", names, layout)


def _header_faults(file: str, names: list[str], layout: Layout, row: int | None = 1) -> list[Fault]:
    """Return what is wrong with the names of the columns, contents aside."""
    wanted = ",".join(layout.required)
    if len(names) == 1 and ";" in names[0]:
        return [Fault(file, f"cells are separated by ';'; write commas, and points in numbers: {wanted}", row)]
    if all(_NUMBER.fullmatch(name) for name in names):
        return [Fault(file, f"there is no header; the first line has to be {wanted}", row)]
    faults = []
    known = [*layout.required, *layout.optional]
    unknown = [name for name in names if name not in known]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            faults.append(Fault(file, f"{names.count(name)} columns have this name; keep one", row, name or None))
        elif not name:
            faults.append(Fault(file, "a column without a name; name it or remove it", row))
        elif name in unknown and (message := layout.refuse(name)):
            faults.append(Fault(file, message, row, name))
        elif name in unknown and not layout.extras:
            message = f"an unknown column; {did_you_mean(name, known)}the columns are {wanted}; remove or rename it"
            faults.append(Fault(file, message, row, name))
    for name in layout.required:
        if name not in names:
            hint = did_you_mean(name, unknown).replace("did you mean", "is it").replace("? ", "? rename it; ")
            faults.append(Fault(file, f"the column is missing; {hint}the header has to name {wanted}", row, name))
    return faults


def _read_csv_by_cell(file: str, raw: bytes, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table in a CSV file, read cell by cell, and add every fault with its row."""
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = len(_LINE_END.split(raw[: error.start].decode("utf-8", "replace")))
        faults.append(Fault(file, f"byte {error.start} is not UTF-8; save the file as UTF-8 text", row))
        return None
    lines = [(i, line) for i, line in enumerate(_LINE_END.split(text), 1) if line.strip()]
    if not lines:
        faults.append(Fault(file, f"the file is empty; its first line has to be {','.join(layout.required)}"))
        return None
    names = _split(lines[0][1])
    if names is None:
        faults.append(Fault(file, "a quote in the header is not closed; close or remove it", lines[0][0]))
        return None
    header_faults = _header_faults(file, names, layout, lines[0][0])
    faults += header_faults
    if any(fault.column is None and len(header_faults) == 1 for fault in header_faults):
        return None
    rows, numbers = [], []
    for number, line in lines[1:]:
        cells = _split(line)
        if cells is None:
            faults.append(Fault(file, "a quote is not closed; close or remove it", number))
        elif len(cells) != len(names):
            message = f"{len(cells)} cells where the header names {len(names)}; complete or remove the row"
            faults.append(Fault(file, message, number))
        else:
            rows.append(cells)
            numbers.append(number)
    table = Table(file, {}, lambda: np.array(numbers, dtype=np.int64), whole=len(rows) == len(lines) - 1)
    for j, name in enumerate(names):
        if name and names.count(name) == 1:
            cells = [row[j] for row in rows]
            table.columns[name] = _text(cells) if name in layout.text else _numbers(cells)
            _check_text_cells(table, name, cells, layout, faults)
    _check_cells(table, layout, faults)
    return table


def _text(cells: list[str]) -> np.ndarray:
    """Return text as an array of objects, without the blanks around it."""
    column = np.empty(len(cells), dtype=object)
    column[:] = [cell.strip() for cell in cells]
    return column


def _numbers(cells: list[str]) -> np.ndarray:
    """Return the cells as float64, NaN where one is not a number."""
    return np.array(
        [float(c) if _NUMBER.fullmatch(c) or _NOT_FINITE.fullmatch(c) else np.nan for c in cells], dtype=float
    )


def _check_text_cells(table: Table, name: str, cells: list[str], layout: Layout, faults: list[Fault]) -> None:
    """Report cells of a numeric column that are no numbers at all."""
    if name in layout.text:
        return
    wrong = np.array([not (_NUMBER.fullmatch(c) or _NOT_FINITE.fullmatch(c)) for c in cells], dtype=bool)
    known = [*layout.required, *layout.optional]
    if name not in known and 2 * np.count_nonzero(wrong) > len(cells):
        hint = did_you_mean(name, known)
        message = f"an unknown column that holds text ({shorten(cells[0])}); {hint}further columns hold numbers; remove it"
        row = None if len(table.line_numbers()) == 0 else 1
        faults.append(Fault(table.file, message, row, name))
        table.bad[name] = np.ones(len(cells), dtype=bool)
        return

    def message_of(i: int) -> str:
        if not cells[i]:
            return "an empty cell; write the number, or remove the row"
        hint = "write a decimal point, as in 0.123" if "," in cells[i] else "write it as 0.123"
        return f"not a number ({shorten(cells[i])}); {hint}"

    table.report(faults, name, wrong, message_of)


def _check_cells(table: Table, layout: Layout, faults: list[Fault]) -> None:
    """Report text that is missing, numbers that are not finite, and integers that are none."""
    for name, values in table.columns.items():
        if name in layout.text:
            empty = np.array([not cell for cell in values], dtype=bool)
            table.report(faults, name, empty, lambda i: "an empty cell; fill it in, or remove the row")
            continue
        finite = np.isfinite(values)
        if not finite.all():
            message = "not a finite number ({}); write the number, or remove the row"
            table.report(faults, name, ~finite, lambda i, v=values: message.format(v[i]))
        if name in layout.integers:
            with np.errstate(invalid="ignore"):
                broken = finite & ((values != np.round(values)) | (np.abs(values) > MAX_INTEGER))
            table.report(faults, name, broken, lambda i, v=values: f"not an integer ({v[i]:.17g}); write one as 17")


def read_parquet(path: Path, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table of numbers in a Parquet file, None if nothing of it can be used; faults are added."""
    file = path.name
    try:
        content = pq.ParquetFile(path).read()
    except Exception as error:  # a damaged file makes pyarrow raise nearly anything
        reason = " ".join(str(error).split())[:80]
        faults.append(Fault(file, f"cannot be read as Parquet ({reason}); it may be cut short: write or copy it again"))
        return None
    faults += _header_faults(file, content.column_names, layout, None)
    table = Table(file, {}, lambda: np.arange(1, content.num_rows + 1))
    for name in layout.required:
        if content.column_names.count(name) != 1:
            continue
        column = content[name]
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        kind = column.type
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            faults.append(Fault(file, f"holds {kind}, not numbers; write it as double or int64", column=name))
            continue
        table.columns[name] = pc.cast(column, pa.float64(), safe=False).to_numpy()
        empty = np.asarray(pc.is_null(column).to_numpy(zero_copy_only=False), dtype=bool)
        table.report(faults, name, empty, lambda i: "an empty cell; write the number, or remove the row")
    _check_cells(table, layout, faults)
    return table
