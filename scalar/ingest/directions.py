"""Directions of approach as foreign tables write them: 1 and -1, + and -, or words that a mapping translates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scalar.data.located_table import shorten
from scalar.errors import Fault
from scalar.geometry.se3 import Array
from scalar.ingest.raw_table import RawTable, Reference

_SIGNS = {"+": 1.0, "-": -1.0, "\N{MINUS SIGN}": -1.0}
_TEXTS_SHOWN = 4


def read_directions(
    raw: RawTable,
    name: str,
    reference: Reference,
    stated: Mapping[str, float] | None,
    faults: list[Fault],
) -> tuple[Array, Array]:
    """Return the directions of approach in a column, ``(N,)``, and in which rows it is empty, ``(N,)`` bool.

    A joint that stands still, for which the mapping states 0, keeps the direction of the row above. Before its first move it stays 0, which no
    dataset may have.

    Args:
        raw: The file.
        name: The column of the dataset, such as ``approach1``.
        reference: The column of the file.
        stated: ``{text: 1, -1 or 0}`` from the key ``values`` of the mapping; None if there is none.
        faults: Every fault found is added here.
    """
    cells, missing = raw.text(reference)
    texts = list(dict.fromkeys(cells[~missing].tolist()))
    known = {**_SIGNS, **(stated or {})}
    if stated is None and not _SIGNS.keys() >= set(texts):
        others = [text for text in texts if raw.written.number(text) is None]
        if not others:
            return raw.numbers(reference, faults)
    else:
        others = [text for text in texts if text not in known]
    values = np.array([known.get(cell, np.nan) for cell in cells.tolist()])
    label = raw.label(reference)
    if others:
        first = int(np.flatnonzero(cells == others[0])[0])
        shown = ", ".join(shorten(text) for text in others[:_TEXTS_SHOWN])
        more = f" and {len(others) - _TEXTS_SHOWN} more" if len(others) > _TEXTS_SHOWN else ""
        message = f"not a direction ({shown}{more}); {_remedy(name, others, stated)}"
        faults.append(Fault(raw.file, message, int(raw.lines[first]), label))
        return values, missing
    before = values[~missing]
    moved = np.flatnonzero(before != 0.0)
    if len(moved) < len(before):
        last = np.searchsorted(moved, np.arange(len(before)), side="right") - 1
        values[~missing] = np.where(last < 0, 0.0, before[moved[np.maximum(last, 0)]] if len(moved) else 0.0)
    return values, missing


def _remedy(name: str, others: list[str], stated: Mapping[str, float] | None) -> str:
    """Return what to write in the mapping for texts that are no directions."""
    key = f"poses.columns.{name}"
    if stated is not None:
        return f"add it to {key}.values in the mapping, as 1, -1 or 0 (the joint stands still), or leave these rows out"
    one, two = [*others, "...", "..."][:2]
    pair = f"{{'{one}': 1, '{two}': -1}}"
    return f"say which text stands for 1 and which for -1, as in values: {pair}, for {key} in the mapping; or write 1 and -1"
