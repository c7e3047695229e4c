"""Tables in which each row is a whole profile: they become tables with a row for each point.

Profilers save them so (Keyence LJ): the headers of the columns state x, and each row has the values of z there, beside columns such as the profile's
number. Where the headers only count the values, or name them, x follows from its first value and its step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.located_table import NUMBER, shorten
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.raw_table import ROW, RawTable, Reference

X, Z = "@x", "@z"
"""The columns that a table of profiles has in addition, once it is one of points; and ``ROW``, which profile of the file a point belongs to."""


@dataclass(frozen=True)
class RowProfiles:
    """Where the values of the profiles stand.

    Attributes:
        first_column: The column of the first value, after which all columns are values; None if all columns with a number as header are.
        first_x: x of the first value, in the unit of x; None if the headers of the columns state it.
        step: By how much x grows from value to value; None with ``first_x``.
    """

    first_column: Reference | None = None
    first_x: float | None = None
    step: float | None = None


def points_of_rows(table: RawTable, where: RowProfiles) -> RawTable:
    """Return the points of a table of profiles, a row each: its other columns, then ``@x``, ``@z`` and ``@row``. Lines are those of the profiles.

    Raises:
        InvalidInput: There are no values, or nothing states their x.
    """
    headers = table.names or tuple(str(k + 1) for k in range(len(table.cells)))
    numbers = [header.replace(",", ".") if table.written.decimal == "," else header for header in headers]
    if where.first_column is not None:
        values = list(range(table.find(where.first_column), len(headers)))
    else:
        values = [k for k, header in enumerate(numbers) if table.names and NUMBER.fullmatch(header)]
    if not values:
        message = (
            "no column has a number as its header, which would be the x of its values; state first_column, first_x and step under "
            "points.row_profiles in the mapping"
        )
        raise InvalidInput(Fault(table.file, message))
    x = _x(table, [numbers[k] for k in values], where)
    n, m = len(table.lines), len(values)
    others = [k for k in range(len(headers)) if k not in set(values)]
    cells = [np.repeat(table.cells[k], m) for k in others]
    z = np.stack([table.cells[k] for k in values], axis=1).reshape(n * m)
    profile = np.repeat(np.arange(1.0, n + 1.0), m)
    return replace(
        table,
        names=(*(headers[k] for k in others), X, Z, ROW),
        cells=(*cells, np.tile(x, n), z, profile),
        lines=np.repeat(table.lines, m),
    )


def _x(table: RawTable, headers: list[str], where: RowProfiles) -> Array:
    """Return x of each value of a profile ``(m,)``, in the file's unit."""
    if where.first_x is not None and where.step is not None:
        return where.first_x + where.step * np.arange(len(headers))
    remedy = "state first_x and step under points.row_profiles in the mapping"
    wrong = [header for header in headers if not NUMBER.fullmatch(header)]
    if wrong or table.names is None:
        what = f"the header {shorten(wrong[0])} is not a number" if wrong else "its columns have no headers"
        raise InvalidInput(Fault(table.file, f"{what}, so that nothing states x of the values; {remedy}"))
    x = np.array([float(header) for header in headers])
    if len(x) > 1 and x[0] in (0.0, 1.0) and np.all(np.diff(x) == 1.0):
        message = f"the headers of the values ({headers[0]}, {headers[1]}, ...) count them, and do not state x; {remedy}"
        raise InvalidInput(Fault(table.file, message))
    return x
