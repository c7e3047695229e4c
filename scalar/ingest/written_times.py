"""Times as foreign tables write them: times of day, and dates with them; both become seconds after a midnight.

Clocks have 24 hours, or 12 with AM and PM. Dates have the year first, or last: then the day stands first between points, and the day or the month
between slashes and dashes. Which of the two it is follows from a number above 12, or from the times of a column, which never decrease in
one of the two orders alone; else the mapping has to state it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from scalar.data.located_table import shorten
from scalar.geometry.se3 import Array

DAY = 86_400.0  # s
DAY_FIRST, MONTH_FIRST = "day/month/year", "month/day/year"
"""The orders that the key ``text.dates`` of a mapping may state."""
_CLOCK = r"(?P<hour>\d{1,2}):(?P<minute>[0-5]\d)(?::(?P<second>[0-5]\d(?:[.,]\d+)?))?(?:\s*(?P<half>[AaPp])\.?\s?[Mm]\.?)?"
_TIME_OF_DAY = re.compile(_CLOCK)
_DATE = re.compile(r"\s*\d{1,4}([-./])\d{1,2}\1\d{1,4}(?!\d)")
_ISO = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}")
"""The beginning of a date with a time of day as ISO 8601 has it, year first."""
_DATE_AND_TIME = re.compile(
    rf"(?P<first>\d{{1,4}})(?P<sign>[-./])(?P<middle>\d{{1,2}})(?P=sign)(?P<last>\d{{1,4}})(?:[T ]|,\s)\s*{_CLOCK}"
    r"\s*(?P<zone>Z|[-+]\d{2}:?\d{2})?"
)
_CENTURY = 2000  # of years that are written with two digits


@dataclass(frozen=True)
class Clock:
    """Times of a column.

    Attributes:
        seconds: ``(N,)`` [s], after the midnight before the earliest of them.
        midnight: That midnight as seconds of the Unix epoch; None if the column has no dates.
    """

    seconds: Array
    midnight: float | None = None


@dataclass(frozen=True)
class Unsettled:
    """Dates whose order of day and month cannot be told.

    Attributes:
        row: The index of a cell with such a date.
        message: What is wrong with it, and what to do.
    """

    row: int
    message: str


def read_times(cells: Sequence[str], stated: str | None = None) -> Clock | Unsettled | None:
    """Return the times in cells, all of which have to be times of day, or all dates with times of day; None if they are not.

    Dates have to state their time zone all or none: those without one might be hours away from the others. Those with one count from a midnight of
    UTC. A time of day more than half a day before that of the cell above belongs to the next day. AM and PM stand in all cells or in none.

    Args:
        cells: The cells of a column, in the order of the file.
        stated: ``DAY_FIRST`` or ``MONTH_FIRST`` if the mapping states the order; else None.
    """
    times = [_TIME_OF_DAY.fullmatch(cell) for cell in cells]
    if times and all(times):
        return _times_of_day([found for found in times if found])
    dates = [_DATE_AND_TIME.fullmatch(cell.strip()) for cell in cells]
    order = stated
    open_rows = [i for i, found in enumerate(dates) if found and _is_open(found)]
    if order is None and open_rows:
        settled = _settled([found if found and _is_open(found) else None for found in dates])
        if isinstance(settled, Unsettled):
            return settled
        order = settled
    moments = [
        moment
        for cell, found in zip(cells, dates, strict=True)
        if (moment := _moment(cell, found, order if found and _is_open(found) else stated)) is not None
    ]
    if stated is not None and open_rows and len(moments) < len(cells):
        for i in open_rows:
            if _moment(cells[i], dates[i], order) is None:
                message = f"no date in the order {stated} ({shorten(cells[i])}), which text.dates in the mapping states; correct it"
                return Unsettled(i, message)
    halves = {found["half"] is None for found in dates if found}
    if not moments or len(moments) < len(cells) or len(halves) > 1:
        return None
    if len({moment.tzinfo is None for moment in moments}) > 1:
        return None
    seconds = [(moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp() for moment in moments]
    midnight = min(seconds) - min(seconds) % DAY
    return Clock(np.array(seconds) - midnight, midnight)


def is_date(cell: str) -> bool:
    """Return whether a cell begins with a date."""
    return _DATE.match(cell) is not None


def _times_of_day(found: Sequence[re.Match[str]]) -> Clock | None:
    """Return times of day, counted on past midnight; None if only some have AM or PM, or one is none of a clock of 12 hours."""
    if len({one["half"] is None for one in found}) > 1 or any(_hour(one) is None for one in found):
        return None
    parts = [[_hour(one) or 0, float(one["minute"]), _second(one)] for one in found]
    times = np.array(parts, dtype=float) @ [3600.0, 60.0, 1.0]
    days = np.cumsum(np.diff(times, prepend=times[:1]) < -DAY / 2)
    return Clock(times + DAY * days)


def _hour(found: re.Match[str]) -> int | None:
    """Return the hour of a time of day, 0 to 23; None if it has AM or PM and is not 1 to 12."""
    hour = int(found["hour"])
    if found["half"] is None:
        return hour
    if not 1 <= hour <= 12:
        return None
    return hour % 12 + (12 if found["half"] in "Pp" else 0)


def _second(found: re.Match[str]) -> float:
    return float((found["second"] or "0").replace(",", "."))


def _is_open(found: re.Match[str]) -> bool:
    """Return whether the day or the month of a date may stand first: its year stands last, and no points are between."""
    return len(found["first"]) <= 2 and len(found["last"]) in (2, 4) and found["sign"] != "."


def _settled(found: Sequence[re.Match[str] | None]) -> str | Unsettled:
    """Return the order of day and month that the dates of a column have by themselves; entries that are None are no such dates."""
    rows = [i for i, one in enumerate(found) if one]
    dates = [one for one in found if one]
    large = {
        order: next((i for i, one in zip(rows, dates, strict=True) if int(one[part]) > 12), None)
        for order, part in ((DAY_FIRST, "first"), (MONTH_FIRST, "middle"))
    }
    by_number = [order for order, row in large.items() if row is not None]
    if len(by_number) == 2:
        row = max(row for row in large.values() if row is not None)
        if large[DAY_FIRST] == large[MONTH_FIRST]:
            return Unsettled(
                row, f"no date ({shorten(dates[rows.index(row)][0])}), since it has no month; correct it"
            )
        message = f"a date ({shorten(dates[rows.index(row)][0])}) in which the day stands where the month stands in others; write all dates alike"
        return Unsettled(row, message)
    if by_number:
        return by_number[0]
    increasing = [order for order in large if _never_decreases([_moment("", one, order) for one in dates])]
    if len(increasing) == 1:
        return increasing[0]
    if all(one["first"].lstrip("0") == one["middle"].lstrip("0") for one in dates):
        return DAY_FIRST  # the same in both orders
    message = (
        f"a date ({shorten(dates[0][0])}) in which the day or the month may stand first, and no other row says which: write dates: {DAY_FIRST} or "
        f"dates: {MONTH_FIRST} under text in the mapping"
    )
    return Unsettled(rows[0], message)


def _never_decreases(moments: Sequence[datetime | None]) -> bool:
    times = [moment.replace(tzinfo=None) for moment in moments if moment is not None]
    return len(times) == len(moments) and times == sorted(times)


def _moment(cell: str, found: re.Match[str] | None, order: str | None) -> datetime | None:
    """Return a date with a time of day, and with its time zone if it is stated; None if it is none.

    Args:
        cell: What the file has.
        found: Its parts; None if it does not consist of such.
        order: The order of day and month in dates that end in the year; None: days first.
    """
    if found is None or len(found["first"]) == 4:
        try:
            if _ISO.match(cell) and (found is None or found["half"] is None):
                return datetime.fromisoformat(cell.strip().replace(",", "."))
        except ValueError:
            return None
    if found is None:
        return None
    first, middle, last = (int(found[part]) for part in ("first", "middle", "last"))
    if len(found["first"]) == 4:
        year, month, day = first, middle, last
    elif len(found["first"]) <= 2 and len(found["last"]) in (2, 4):
        year = last if len(found["last"]) == 4 else _CENTURY + last
        month, day = (first, middle) if order == MONTH_FIRST else (middle, first)
    else:
        return None
    if (hour := _hour(found)) is None:
        return None
    second, _, fraction = (found["second"] or "00").replace(",", ".").partition(".")
    clock = f"{hour:02d}:{found['minute']}:{second}.{fraction[:6]:0<6}"
    text = f"{year:04d}-{month:02d}-{day:02d}T{clock}{found['zone'] or ''}"
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        return None
