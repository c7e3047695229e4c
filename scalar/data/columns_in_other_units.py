"""A column that is missing, and is there in another unit, as the end of its name says: ``q1_deg`` for ``q1``, ``X [mm]`` for ``x``."""

from __future__ import annotations

from collections.abc import Sequence

_IN_SI = {"deg": "radians", "degrees": "radians", "°": "radians", "mm": "metres", "cm": "metres"}
"""Units that a name may state at its end, with what the numbers have to be converted to."""


def in_another_unit(name: str, others: Sequence[str]) -> str:
    """Return the hint to convert a column that stands among other names with another unit at its end; empty if there is none.

    Args:
        name: The column that is missing; it is expected in m or rad.
        others: Names of columns that are not known.
    """
    for other in others:
        unit = other[len(name) :].strip(" _[]()").lower() if other.lower().startswith(name.lower()) else ""
        if unit in _IN_SI:
            return f"is it {other!r}? convert its numbers to {_IN_SI[unit]} and rename it; "
    return ""
