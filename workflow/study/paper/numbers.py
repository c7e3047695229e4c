"""Collect the numbers that the paper quotes: every number in the files of results, with a key, rounded and with its unit.

A key is the name of a part followed by the path of the number in its file, ``headline.methods.proposed.raw.position_mean_mm.mean``. The
unit is that at the end of the number's name, or of the nearest name on its path (``_mm``, ``_deg``). Each number is rounded to several numbers of
digits, of which the text chooses one, so that all numbers are formatted here and the text contains none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from scalar.errors import Fault, InvalidInput
from scalar.units import DEG, MM, MRAD, UM

MOST_DIGITS = 5  # largest number of significant digits that the text may choose
EXPONENT_BELOW, EXPONENT_FROM = 1e-4, 1e6  # smaller and larger numbers are written with a power of ten
NARROW_SPACE = "\u202f"  # between a number and its unit: no line breaks there
UNITS = {
    "mm": "mm",
    "um": "µm",
    "m": "m",
    "deg": "°",
    "rad": "rad",
    "mrad": "mrad",
    "urad": "µrad",
    "s": "s",
    "ms": "ms",
    "percent": "%",
}
"""``{last word of a name: unit that is written after the number}``."""
SMALL = {"m": ("mm", 1 / MM)}
"""``{unit: (unit in which numbers below a tenth are written, factor to it)}``."""
ANGLES = {"rad": ("deg", 1 / DEG), "mrad": ("deg", MRAD / DEG), "urad": ("deg", UM / DEG)}
"""``{unit of an angle: (degrees, factor to them)}``, since the paper states all angles in degrees."""
POWER = "×10^"
"""Text before the exponent of a number that is too small or too large to be written out; the paper typesets it as a power."""


def gather(parts: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``{"parts": names, "numbers": {key: entry}}`` for the contents of several files.

    An entry contains ``text``, the number with 1 to ``MOST_DIGITS`` significant digits (one text for a whole number or a word);
    ``unit``, with the space before it; and, for a number between 0 and 1 without a unit, ``percent``.

    Args:
        parts: ``{name: content}``, with mappings and lists of numbers, words and truth values.

    Raises:
        InvalidInput: Two numbers have the same key.
    """
    numbers: dict[str, Any] = {}
    for part, content in parts.items():
        for key, value, unit in _leaves(part, content, ""):
            if key in numbers:
                raise InvalidInput(Fault(part, f"the paper's numbers have {key!r} twice; rename one"))
            numbers[key] = entry(value, unit)
    return {"parts": list(parts), "numbers": numbers}


def _leaves(key: str, value: Any, unit: str) -> Iterator[tuple[str, Any, str]]:
    """Yield (key, value, unit) of every leaf; a list's items are numbered from 1, and its length is a leaf of its own."""
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _leaves(f"{key}.{name}", item, unit_of(str(name)) or unit)
    elif isinstance(value, list):
        yield f"{key}.count", len(value), ""
        for i, item in enumerate(value, start=1):
            yield from _leaves(f"{key}.{i}", item, unit)
    else:
        yield key, value, unit


def unit_of(name: str) -> str:
    """Return the unit at the end of a name, as in ``position_mean_mm``; an empty text if it has none."""
    last = name.rsplit("_", 1)
    return last[1] if len(last) == 2 and last[1] in UNITS else ""


def entry(value: Any, unit: str) -> dict[str, Any]:
    """Return the entry of a number, as ``gather`` describes it."""
    if value is None:
        return {"text": ["–"], "unit": ""}
    if isinstance(value, bool):
        return {"text": ["yes" if value else "no"], "unit": ""}
    if isinstance(value, str):
        return {"text": [value], "unit": ""}
    if not math.isfinite(value):
        return {"text": ["∞" if value > 0 else "–"], "unit": ""}
    other = ANGLES.get(unit) or (SMALL.get(unit) if 0 < abs(value) < 0.1 else None)
    if other is not None:
        unit, factor = other
        value *= factor
    mark = UNITS.get(unit, "")
    shown = {"text": [rounded(value, digits) for digits in range(1, MOST_DIGITS + 1)]}
    if isinstance(value, int):
        shown = {"text": [grouped(value)]}
    elif 0.0 <= value <= 1.0 and not unit:
        shown["percent"] = [f"{100 * value:.{places}f}" for places in range(3)]
    return shown | {"unit": f"{'' if mark == '°' else NARROW_SPACE}{mark}" if mark else ""}


def rounded(value: float, digits: int) -> str:
    """Return a number with so many significant digits, also if the last ones are zeros: ``0.018``, ``1.20``, ``3.1×10^−6``, ``15,000``."""
    if value == 0:
        return "0"
    size = abs(value)
    exponent = int(f"{size:.{digits - 1}e}".split("e")[1])
    if not EXPONENT_BELOW <= size < EXPONENT_FROM:
        mantissa = f"{size / 10.0**exponent:.{digits - 1}f}"
        text = f"{mantissa}{POWER}{exponent}".replace("^-", "^−")
    else:
        places = digits - 1 - exponent
        text = f"{size:.{places}f}" if places > 0 else grouped(int(round(size, places)))
    return f"−{text}" if value < 0 else text


def grouped(value: int) -> str:
    """Return a whole number, with commas between thousands from ten thousand on: ``4096``, ``10,000``."""
    text = f"{abs(value):,}" if abs(value) >= 10_000 else str(abs(value))
    return f"−{text}" if value < 0 else text
