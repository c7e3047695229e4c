"""The faults of the rows of a table that its header does not fit: one by one, or their cause where all of them have it."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.located_table import MAX_SHOWN
from scalar.errors import Fault


def faults_of_rows(
    file: str, wrong: Sequence[tuple[int, str]], uneven: Sequence[Sequence[str]], width: int
) -> list[Fault]:
    """Return the faults of the rows of a table, or a single one if all rows have more cells than the header names for one cause.

    Args:
        file: Name of the table.
        wrong: The number of the line of each wrong row, and what is wrong.
        uneven: The cells of the rows with another number of cells, if no row has the right one; else none.
        width: How many columns the header names.
    """
    if len(uneven) > 1 and (cause := _common_cause(uneven, width)):
        return [Fault(file, f"all {len(uneven)} rows have more cells than the header names: {cause}")]
    faults = [Fault(file, message, number) for number, message in wrong[:MAX_SHOWN]]
    if len(wrong) > MAX_SHOWN:
        more = f"{len(wrong) - MAX_SHOWN} more rows that are not as long as the header, the last in row {wrong[-1][0]}"
        faults.append(Fault(file, f"{more}; look for a common cause"))
    return faults


def _common_cause(rows: Sequence[Sequence[str]], width: int) -> str:
    """Return as a question why all rows have more cells than the header names, ``width``; empty if nothing explains it."""
    if all(len(cells) == width + 1 and not cells[-1] for cells in rows):
        return "does each of them end with a comma? remove it"
    if all(len(cells) > width and all("." not in cell for cell in cells) for cells in rows):
        return "are these decimal commas? write a point in each number, as in 0.5"
    return ""
