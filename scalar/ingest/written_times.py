"""Times as foreign tables write them: times of day, and dates with them; both become seconds after a midnight."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

DAY = 86_400.0  # s
_TIME_OF_DAY = re.compile(r"(\d{1,2}):([0-5]\d)(?::([0-5]\d(?:[.,]\d+)?))?")
_DATE = re.compile(r"\s*\d{1,4}([-./])\d{1,2}\1\d{1,4}(?!\d)")
_DATE_AND_TIME = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}")
"""The beginning of a date with a time of day, year first."""
_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[T ]\s*(\d{1,2})(:\d{2}.*)")
"""A date with a time of day as 26.11.2026 09:04:30; with slashes, the day or the month may stand first, so that such dates are not read."""


@dataclass(frozen=True)
class Clock:
    """Times of a column.

    Attributes:
        seconds: ``(N,)`` [s], after the midnight before the earliest of them.
        midnight: That midnight as seconds of the Unix epoch; None if the column has no dates.
    """

    seconds: np.ndarray
    midnight: float | None = None


def read_times(cells: list[str]) -> Clock | None:
    """Return the times in cells, all of which have to be times of day, or all dates with times of day; None if they are not.

    Dates have to state their time zone all or none: those without one might be hours away from the others. Those with one count from a midnight of
    UTC. A time of day more than half a day before that of the cell above belongs to the next day.
    """
    found = [_TIME_OF_DAY.fullmatch(cell) for cell in cells]
    if found and all(found):
        parts = [[float((part or "0").replace(",", ".")) for part in m.groups()] for m in found if m]
        times = np.array(parts) @ [3600.0, 60.0, 1.0]
        days = np.cumsum(np.diff(times, prepend=times[:1]) < -DAY / 2)
        return Clock(times + DAY * days)
    moments = [moment for moment in map(moment_of, cells) if moment is not None]
    if not moments or len(moments) < len(cells) or len({moment.tzinfo is None for moment in moments}) > 1:
        return None
    seconds = [(moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp() for moment in moments]
    midnight = min(seconds) - min(seconds) % DAY
    return Clock(np.array(seconds) - midnight, midnight)


def is_date(cell: str) -> bool:
    """Return whether a cell begins with a date."""
    return _DATE.match(cell) is not None


def moment_of(cell: str) -> datetime | None:
    """Return a date with a time of day, and with its time zone if it is stated; None if it is none.

    Dates are read as ISO 8601 has them, year first, or with points between day, month and year.
    """
    if found := _DAY_FIRST.fullmatch(cell.strip()):
        day, month, year, hour, rest = found.groups()
        cell = f"{year}-{month:0>2}-{day:0>2} {hour:0>2}{rest}"
    if not _DATE_AND_TIME.match(cell):
        return None
    try:
        return datetime.fromisoformat(cell.strip().replace(",", "."))
    except ValueError:
        return None
