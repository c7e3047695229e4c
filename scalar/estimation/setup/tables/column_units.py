"""One column of the measured points in another unit than the others, as where x of a profile is exported in millimetres and z in metres.

Of several targets on one flange, a column of one alone may be, or all columns of one, since a mapping states the unit of each. A table in which all
columns are in another unit is an alternative of ``scalar.estimation.setup.alternatives``. Here the other columns set the scale, so a smaller residual
is not a matter of smaller lengths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

_UNITS = (("millimetres", "mm", MM), ("centimetres", "cm", 10 * MM), ("inches", "in", 25.4 * MM))
"""Units that a column may be in where metres are meant, each with its key in a mapping and its size in metres."""
_TAKEN_FOR_MM = (("centimetres", 10.0), ("inches", 25.4))
"""Units that are taken for millimetres, or millimetres for them, each with its size in millimetres."""
_MOST_TARGETS = 4  # of which each is tried alone; chosen, because every target adds 40 readings


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of the measured points that a mapping gives one unit.

    Attributes:
        rows: ``(P,)`` bool, the points.
        columns: ``(k,)`` bool, their columns.
        name: What it is, with its verb: ``the column x is``.
        others: What sets the scale: ``y and z``.
        key: What the mapping calls it.
    """

    rows: Array
    columns: Array
    name: str
    others: str
    key: str


def column_units(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one column of the measured points, or those of one target, have another unit than the others."""
    if not len(dataset.points):
        return
    file = kind_of(dataset).format.measured_in
    for part in _parts(dataset):
        for factor, says, remedy in _readings(part):
            points = dataset.points.copy()
            points[np.ix_(part.rows, part.columns)] *= factor
            changed = f"with {part.key} multiplied by {factor:.6g}"
            yield Alternative("length_unit", file, says, changed, remedy, replace(dataset, points=points))


def _parts(dataset: Dataset) -> Iterator[_Part]:
    """Yield the parts of the points: each column, and of several targets each column of one, and all columns of one."""
    names = ("x", "z") if dataset.points.shape[-1] == 2 else ("x", "y", "z")
    every = np.ones(len(dataset.points), dtype=bool)
    owner = dataset.point_columns.get("target")
    alone = dataset.targets if owner is not None and 1 < len(dataset.targets) <= _MOST_TARGETS else ()
    for target in (None, *alone):
        rows = every if target is None else owner == dataset.targets.index(target)
        of_target = "" if target is None else f" of target {target}"
        for k, name in enumerate(names):
            others = " and ".join(other for other in names if other != name)
            key = name + of_target
            yield _Part(rows, np.arange(len(names)) == k, f"the column {key} is", others, key)
        if target is not None:
            all_columns = np.ones(len(names), dtype=bool)
            key = ", ".join(names) + of_target
            yield _Part(rows, all_columns, f"the columns {key} are", "those of the other targets", key)


def _readings(part: _Part) -> Iterator[tuple[float, str, str]]:
    """Yield by which factor a part has to be multiplied, what is wrong with it then, and what to do."""
    write = f"write {part.key} in metres, as {part.others}; where 'scalar import' made the table, "
    correct = f"{write}correct the unit of {part.key} in the mapping"
    small, large = (f"times too {size} compared with {part.others}" for size in ("small", "large"))
    for unit, key, size in _UNITS:
        said = f"{part.name} in {unit}, and {part.others} in metres"
        yield size, said, f"{write}write unit: {key} for {part.key} in the mapping"
        yield (
            1.0 / size,
            f"{part.name} {1.0 / size:.4g} {small}, as metres are that were taken for {unit}",
            correct,
        )
    for unit, times in _TAKEN_FOR_MM:
        yield (
            times,
            f"{part.name} {times:.4g} {small}, as {unit} are that were taken for millimetres",
            correct,
        )
        yield (
            1.0 / times,
            f"{part.name} {times:.4g} {large}, as millimetres are that were taken for {unit}",
            correct,
        )
