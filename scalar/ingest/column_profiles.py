"""Tables in which each column is a whole profile: they become tables with a row for each point.

One column states x, and every column after it has the values of z of one profile. The header of such a column names its profile (``P001``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.located_table import shorten
from scalar.errors import Fault, InvalidInput
from scalar.ingest.raw_table import HEAD_NUMBER, RawTable, Reference, last_number
from scalar.ingest.row_profiles import ROW, X, Z


@dataclass(frozen=True)
class ColumnProfiles:
    """Where the values of the profiles stand.

    Attributes:
        x: The column that states x; all columns after it are profiles.
    """

    x: Reference


def points_of_columns(table: RawTable, where: ColumnProfiles) -> RawTable:
    """Return the points of a table of profiles, a row each.

    Its columns are ``@x``, ``@z``, ``@row`` (which profile of the file, from 1) and, where every profile's header has a number of its own,
    ``@head_number``.

    Raises:
        InvalidInput: There is no such column, or none after it.
    """
    first = table.find(where.x) + 1
    values = range(first, len(table.cells))
    if not values:
        message = f"no column after {shorten(str(where.x))}; each of them is a profile, and points.column_profiles names the column of x before"
        raise InvalidInput(Fault(table.file, message))
    n, m = len(table.lines), len(values)
    headers = table.names or tuple(str(k + 1) for k in range(len(table.cells)))
    numbers = [last_number(headers[k]) for k in values]
    columns = {
        X: np.tile(table.cells[first - 1], m),
        Z: np.concatenate([table.cells[k] for k in values]),
        ROW: np.repeat(np.arange(1.0, m + 1.0), n),
    }
    if None not in numbers and len(set(numbers)) == m:
        columns[HEAD_NUMBER] = np.repeat(np.array(numbers, dtype=float), n)
    return replace(table, names=tuple(columns), cells=tuple(columns.values()), lines=np.tile(table.lines, m))
