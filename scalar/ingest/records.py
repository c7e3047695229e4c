"""Read records in YAML as a table with a row for each record; a record is a mapping in a list.

Laboratory software writes a campaign as a list with a record for each pose (Hilti's construction robot stationing datasets). Lists of records may
stand anywhere in the document, under any keys; their records are taken in the order of the document. Each key of a record gives a column. A list
inside a record gives a column for each entry, `joint_states[1]`, `joint_states[2]` and so on, and a mapping one for each key, `pose.x`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from scalar.data.io.plain_yaml import parse_yaml
from scalar.errors import Fault, InvalidInput
from scalar.ingest.raw_table import MISSING, MOST_COLUMNS, RawTable

_Path = tuple[str | int, ...]
MOST_BYTES = 20_000_000  # largest file that is read; YAML is read a hundred times slower than a table


def read_records(file: str, raw: bytes, missing: list[str]) -> RawTable:
    """Return the records of a YAML document as a table of text with a row for each record; a cell is empty if the record lacks the key.

    Args:
        file: name of the file.
        raw: content of the file.
        missing: texts that mean that nothing was measured, besides the usual ones.

    Raises:
        InvalidInput: the file is not YAML or is larger than ``MOST_BYTES``, or has no record, or more than ``MOST_COLUMNS`` columns.
    """
    if len(raw) > MOST_BYTES:
        message = f"{len(raw) / 1e6:.0f} MB of YAML, more than {MOST_BYTES // 1_000_000}; save it as CSV"
        raise InvalidInput(Fault(file, message))
    content, lines = parse_yaml(file, raw, text_keys=False)
    rows = [(lines[path], dict(_cells(record, ""))) for path, record in _records(content, ())]
    if not rows:
        message = "no list of records (as '- {id: 1, x: 0.5}') and no list 'scan_line', as OpenCV writes a profile; give one of them, or a CSV file"
        raise InvalidInput(Fault(file, message))
    names = tuple(dict.fromkeys(name for _, cells in rows for name in cells))
    if len(names) > MOST_COLUMNS:
        message = f"the records give {len(names)} columns, more than {MOST_COLUMNS}; is it a list with one record for each pose?"
        raise InvalidInput(Fault(file, message))
    columns = []
    for name in names:
        column = np.empty(len(rows), dtype=object)
        column[:] = [cells.get(name, "") for _, cells in rows]
        columns.append(column)
    marks = MISSING | {mark.strip().lower() for mark in missing}
    line_numbers = np.array([line for line, _ in rows], dtype=np.int64)
    return RawTable(file, names, tuple(columns), line_numbers, missing=marks)


def _records(value: Any, path: _Path) -> Iterator[tuple[_Path, dict[str, Any]]]:
    """Yield every record below a value with its path; a mapping inside a record is part of that record, and not one of its own."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _records(inner, (*path, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            if isinstance(inner, dict):
                yield (*path, i), inner
            else:
                yield from _records(inner, (*path, i))


def _cells(value: Any, name: str) -> Iterator[tuple[str, str]]:
    """Yield the name of the column and the text of every cell of a record."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _cells(inner, f"{name}.{key}" if name else key)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _cells(inner, f"{name}[{i + 1}]")
    elif value is None:
        yield name, ""
    elif isinstance(value, bool):
        yield name, str(int(value))
    else:
        yield name, repr(value) if isinstance(value, float) else str(value).strip()
