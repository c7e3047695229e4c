"""Check that no figure, caption, table or formula of the paper overlaps another or leaves the page, by the boxes of the typesetter.

``style.typ`` marks the upper left and the lower right corner of each, and the natural width of formulas and tables. No two boxes of a
page may overlap, none may reach over the margins or be cut off, and nothing may be wider than its column.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

SLACK = 0.5  # [pt] by which boxes may reach into one another: rounding


@dataclass(frozen=True)
class Box:
    """A box on a page; lengths in pt, from the upper left corner of the page.

    Attributes:
        what: What the box contains, for messages.
        page: Number of the page.
        left: Left edge.
        top: Upper edge.
        right: Right edge.
        bottom: Lower edge; infinite if the box continues on the next page.
        height: Height that the box would have on a page without end.
    """

    what: str
    page: int
    left: float
    top: float
    right: float
    bottom: float
    height: float


def layout_faults(marks: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a sentence for each fault of the layout; an empty list without faults.

    Args:
        marks: As ``typeset.placed`` returns them: corners, ``{what, corner, page, x, y, height}``; widths, ``{what, page, width, room}``;
            and one ``{left, top, right, bottom}``, the edges of what the margins leave of a page; lengths in pt.
    """
    page = next(mark for mark in marks if "left" in mark)
    found = boxes([mark for mark in marks if "corner" in mark])
    faults = [
        f"page {a.page}: {a.what} and {b.what} overlap"
        for a, b in itertools.combinations(found, 2)
        if a.page == b.page and _overlap(a, b) > SLACK
    ]
    for box in found:
        over = max(
            page["left"] - box.left,
            page["top"] - box.top,
            box.right - page["right"],
            box.bottom - page["bottom"],
        )
        if over > SLACK:
            faults.append(f"page {box.page}: {box.what} reaches {over:.0f} pt over the margin")
        if (lost := box.height - (box.bottom - box.top)) > SLACK:
            faults.append(f"page {box.page}: of {box.what} {lost:.0f} pt are cut off")
    for mark in marks:
        if "width" in mark and mark["width"] > mark["room"] + SLACK:
            over = mark["width"] - mark["room"]
            faults.append(f"page {mark['page']}: {mark['what']} is {over:.0f} pt wider than its column")
    return faults


def boxes(corners: Sequence[Mapping[str, Any]]) -> list[Box]:
    """Return the boxes, each made of a start corner and an end corner; one that ends on another page has an infinite lower edge."""
    started: dict[str, list[Mapping[str, Any]]] = {}
    found = []
    for mark in corners:
        if mark["corner"] == "start":
            started.setdefault(mark["what"], []).append(mark)
            continue
        first = started[mark["what"]].pop()
        bottom = mark["y"] if mark["page"] == first["page"] else float("inf")
        found.append(
            Box(mark["what"], first["page"], first["x"], first["y"], mark["x"], bottom, mark["height"])
        )
    return found


def _overlap(a: Box, b: Box) -> float:
    """Return how far two boxes of one page overlap [pt], the lesser of both directions; zero or less if they do not."""
    across = min(a.right, b.right) - max(a.left, b.left)
    down = min(a.bottom, b.bottom) - max(a.top, b.top)
    return min(across, down)
