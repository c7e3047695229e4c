"""Numbers that may stand in a table once: of the poses, and of their order."""

from __future__ import annotations

import numpy as np

from scalar.data.located_table import MANY_ROWS, Table
from scalar.errors import Fault


def check_unique(table: Table, column: str, faults: list[Fault], advice: str = "") -> None:
    """Add a fault for each row whose number stands in an earlier row; where that is in another file, one for all rows of the two files.

    Args:
        table: The table, which may come from several files.
        column: Its column that is to have no number twice.
        faults: Where they are added.
        advice: The end of the message.
    """
    if column not in table.columns:
        return
    values = table.columns[column]
    _, first, group = np.unique(values, return_index=True, return_inverse=True)
    first = first[group]
    repeated = (first != np.arange(len(values))) & ~np.isnan(values)
    if not repeated.any():
        return
    lines = table.line_numbers()
    elsewhere = _in_other_files(table, np.flatnonzero(repeated), first)
    repeated[[i for rows in elsewhere.values() for i in rows[1:]]] = False

    at = int(np.argmax(repeated))
    in_all = f"{column} {values[at]:.15g} stands already in row {lines[first[at]]}, and so do the numbers of more rows in rows before them"

    def message(i: int) -> str:
        row = lines[first[i]]
        if table.file_of(i) == (other := table.file_of(int(first[i]))):
            if np.count_nonzero(repeated) > MANY_ROWS and not elsewhere:
                return f"{in_all}; give each row a number of its own, here and in every table that belongs to it{advice}"
            return f"{column} {values[i]:.15g} stands already in row {row}; correct or remove one{advice}"
        what = f"{column} {values[i]:.15g} stands already in {other}, row {row}"
        if more := len(elsewhere[table.file_of(i), other]) - 1:
            what += f", and so {'does' if more == 1 else 'do'} {more} more of this file"
        if column != "pose":
            return f"{what}; correct or remove one"
        return f"{what}; if each file counts its poses anew, write add_to_pose: 1000 for this file, where poses and points are mapped{advice}"

    table.report(faults, column, repeated, message)


def _in_other_files(
    table: Table, repeated: np.ndarray, first: np.ndarray
) -> dict[tuple[str, str], list[int]]:
    """Return the rows of each file whose numbers stand in another file, by the names of both.

    Args:
        table: The table.
        repeated: ``(K,)``, rows whose number stands in an earlier row.
        first: ``(N,)``, the first row with the number of each row.
    """
    found: dict[tuple[str, str], list[int]] = {}
    for i in repeated.tolist():
        if (here := table.file_of(i)) != (other := table.file_of(int(first[i]))):
            found.setdefault((here, other), []).append(i)
    return found
