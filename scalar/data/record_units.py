"""Records of poses.csv that are probably in another unit: loads in grams, temperatures in degrees Fahrenheit or kelvin, times in milliseconds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scalar.data.formats import PAYLOAD

HEAVY = 1000.0  # kg; chosen: hardly any arm carries more, and most payloads in grams are larger
HOT = 60.0  # degrees Celsius; chosen: a hall is cooler, and so is the housing of a joint; in degrees Fahrenheit it is 16 degrees Celsius
KELVIN = 200.0  # likewise: no arm works at it, and in kelvin it is -73 degrees Celsius
SLOW = 1200.0  # s; chosen: the usual time from one pose to the next is seconds or minutes, and in milliseconds thousands


RECORDS = (PAYLOAD[0], "temperature", "time")


def units_suspected(columns: Mapping[str, np.ndarray]) -> list[str]:
    """Return a clause for each column whose numbers are hardly in the unit of the format: what they are, and what to write.

    Args:
        columns: Of poses.csv by name, ``(N,)`` each, those of ``RECORDS`` at least; those that are no numbers are passed over.
    """
    found = []
    masses = _numbers(columns, PAYLOAD[0])
    if masses.max(initial=0.0) > HEAVY:
        count = int(np.count_nonzero(masses > HEAVY))
        found.append(
            f"{PAYLOAD[0]} is as large as {masses.max():g} kg, and more than {HEAVY:g} kg in {count} of {len(masses)} poses; are these grams? "
            "write kilograms"
        )
    temperatures = _numbers(columns, "temperature")
    if temperatures.max(initial=0.0) > HOT:
        unit = "kelvin" if temperatures.min() > KELVIN else "degrees Fahrenheit"
        found.append(
            f"temperature is {temperatures.min():g} to {temperatures.max():g}, in degrees Celsius; are these {unit}? convert them, since growth is "
            "stated for each kelvin"
        )
    times = _numbers(columns, "time")
    if len(times) > 1 and (step := float(np.median(np.abs(np.diff(np.sort(times)))))) > SLOW:
        found.append(
            f"time has {step / 60:.0f} minutes between poses in the median; are these milliseconds? write seconds"
        )
    return found


def _numbers(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the finite numbers of a column, ``(k,)``; none if there is no such column."""
    try:
        values = np.asarray(columns.get(name, ()), dtype=float)
    except (TypeError, ValueError):
        return np.empty(0)
    return values[np.isfinite(values)]
