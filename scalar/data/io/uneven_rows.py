"""Why all rows of a table have more cells than its header names: decimal commas, or a comma at the end of each row."""

from __future__ import annotations

from collections.abc import Sequence


def common_cause(rows: Sequence[Sequence[str]], width: int) -> str:
    """Return as a question why all rows have more cells than the header names, ``width``; empty if nothing explains it."""
    if all(len(cells) == width + 1 and not cells[-1] for cells in rows):
        return "does each of them end with a comma? remove it"
    if all(len(cells) > width and all("." not in cell for cell in cells) for cells in rows):
        return "are these decimal commas? write a point in each number, as in 0.5"
    return ""
