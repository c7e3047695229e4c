"""Records of poses.csv that are probably in another unit.

Loads in newtons or grams, temperatures in degrees Fahrenheit or kelvin, times in milliseconds or in days.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scalar.data.formats import PAYLOAD

HEAVY = 1000.0  # kg; chosen: hardly any arm carries more, and most payloads in grams are larger
OVERLOAD = 2.0  # of the rated payload; chosen: arms are rarely loaded with more, and in newtons a fifth of the rated payload is more
IN_GRAMS = 30.0  # of the rated payload: from here on, newtons would be three times the rated payload, and grams are likelier
HOT = 60.0  # degrees Celsius; chosen: a hall is cooler, and so is the housing of a joint; in degrees Fahrenheit it is 16 degrees Celsius
KELVIN = 200.0  # likewise: no arm works at it, and in kelvin it is -73 degrees Celsius
FAST = 0.01  # s; chosen: no arm is measured at a hundred poses a second, and in days, as spreadsheets count, 0.01 is a quarter of an hour
SLOW = 1200.0  # s; chosen: the usual time from one pose to the next is seconds or minutes, and in milliseconds thousands


FAR = 2.0  # m; chosen: the middle of a load sits nearer to the flange, and in millimetres it is farther
RECORDS = (*PAYLOAD, "temperature", "time")


def units_suspected(columns: Mapping[str, np.ndarray], rated: float | None = None) -> list[str]:
    """Return a clause for each column whose numbers are hardly in the unit of the format: what they are, and what to write.

    Args:
        columns: Of poses.csv by name, ``(N,)`` each, those of ``RECORDS`` at least; those that are no numbers are passed over.
        rated: Rated payload of the arm [kg]; None if it is not known.
    """
    found = _payload_suspected(_numbers(columns, PAYLOAD[0]), rated)
    far = max((float(np.abs(_numbers(columns, name)).max(initial=0.0)) for name in PAYLOAD[1:]), default=0.0)
    if far > FAR:
        found.append(
            f"{', '.join(PAYLOAD[1:])} are as large as {far:g} m from the flange; are these millimetres? write metres"
        )
    temperatures = _numbers(columns, "temperature")
    if temperatures.max(initial=0.0) > HOT:
        unit = "kelvin" if temperatures.min() > KELVIN else "degrees Fahrenheit"
        found.append(
            f"temperature is {temperatures.min():g} to {temperatures.max():g}, in degrees Celsius; are these {unit}? convert them, since growth is "
            "stated for each kelvin"
        )
    times = _numbers(columns, "time")
    step = float(np.median(np.diff(np.sort(times)))) if len(times) > 1 else 0.0
    if step > SLOW:
        found.append(
            f"time has {step / 60:.0f} minutes between poses in the median; are these milliseconds? write seconds"
        )
    elif 0.0 < step < FAST:
        found.append(
            f"time has {step:.2g} s between poses in the median; are these days, as a spreadsheet counts them, or hours? write "
            "seconds"
        )
    return found


def _payload_suspected(masses: np.ndarray, rated: float | None) -> list[str]:
    """Return a clause if payloads ``(k,)`` [kg] are far larger than the rated one [kg], or than any arm carries; none otherwise."""
    heavy = HEAVY if rated is None else min(HEAVY, OVERLOAD * rated)
    largest = masses.max(initial=0.0)
    if largest <= heavy:
        return []
    count = int(np.count_nonzero(masses > heavy))
    more_than, unit = f"{heavy:g} kg", "grams, or newtons"
    if rated is not None:
        more_than += f" ({OVERLOAD:g} times the {rated:g} kg that the name of the arm states)"
        unit = "grams" if largest > IN_GRAMS * rated else "newtons, or pounds"
    return [
        f"{PAYLOAD[0]} is as large as {largest:g} kg, and more than {more_than} in {count} of {len(masses)} poses; are these {unit}? write kilograms"
    ]


def _numbers(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the finite numbers of a column, ``(k,)``; none if there is no such column."""
    try:
        values = np.asarray(columns.get(name, ()), dtype=float)
    except (TypeError, ValueError):
        return np.empty(0)
    return values[np.isfinite(values)]
