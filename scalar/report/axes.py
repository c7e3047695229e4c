"""Axes of charts in degrees and millimetres: labels, values, ranges, and the texts that dots show when they are pointed at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.effects.picture import Axis
from scalar.geometry.se3 import Array
from scalar.report.words import number
from scalar.units import DEG, MM

_UNITS = {
    "rad": (DEG, "°"),
    "m": (MM, "mm"),
    "rad/s": (DEG, "°/s"),
    "m/s": (MM, "mm/s"),
    "m/m": (MM, "mm per m"),
    "s": (1.0, "s"),
    "N m": (1.0, "N m"),
    "degC": (1.0, "°C"),
    "1": (1.0, ""),
    "": (1.0, ""),
}


def unit_of(axis: Axis) -> str:
    """Return the unit in which the values of an axis are shown; empty if they have none."""
    return _UNITS[axis.unit][1]


def in_words(axis: Axis) -> str:
    """Return an axis label with its unit."""
    return f"{axis.label} [{unit_of(axis)}]" if unit_of(axis) else axis.label


def shown(axis: Axis, values: Array) -> Array:
    """Return values ``(...)``, given in SI units, in the unit in which the axis shows them (mm, mrad or degrees, for example)."""
    return np.asarray(values, dtype=float) / _UNITS[axis.unit][0]


def dot_titles(poses: Array, where: Sequence[tuple[Axis, Array]], axis: Axis, values: Array) -> list[str]:
    """Return the text that each dot shows when it is pointed at: pose, place and value, in the units of the axes.

    Args:
        poses: ``(N,)``, the identifier of each dot's pose.
        where: Each axis of the place, with ``(N,)`` values along it, as shown.
        axis: The axis of the value.
        values: ``(N,)``, the values, as shown.
    """
    places = zip(*([_written(a, v) for v in column] for a, column in where), strict=True)
    return [
        f"pose {pose} at {', '.join(place)}: {_written(axis, value)}"
        for pose, place, value in zip(poses, places, values, strict=True)
    ]


def with_unit(axis: Axis, value: float, digits: int = 3) -> str:
    """Return a value, in the unit that it is shown in, with that unit."""
    unit = unit_of(axis)
    return f"{number(float(value), digits)}{'' if unit in ('', '°') else ' '}{unit}"


def _written(axis: Axis, value: float) -> str:
    return f"order {value:g}" if axis.label == "order of acquisition" else with_unit(axis, value)


def range_of(values: Sequence[Array], share: float = 1.0, around_zero: bool = False) -> tuple[float, float]:
    """Return a range that holds the middle ``share`` of all finite values, with a margin; with ``around_zero`` it contains zero too."""
    pool = np.concatenate([np.asarray(v, dtype=float).ravel() for v in values])
    pool = pool[np.isfinite(pool)]
    if not len(pool):
        return -1.0, 1.0
    tail = (1.0 - share) / 2
    low, high = (float(v) for v in np.quantile(pool, [tail, 1.0 - tail]))
    if around_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.06 * (high - low) or max(abs(high), 1e-12) * 0.1
    return low - margin, high + margin
