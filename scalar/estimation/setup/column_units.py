"""One column of the measured points in another unit than the others, as where x of a profile is exported in millimetres and z in metres.

A table in which all columns are in another unit is an alternative of ``scalar.estimation.setup.alternatives``. Here the other columns set the scale,
so a smaller residual is not a matter of smaller lengths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.sensors import kind_of
from scalar.units import MM

_UNITS = (("millimetres", "mm", MM), ("centimetres", "cm", 10 * MM), ("inches", "in", 25.4 * MM))
"""Units that a column may be in where metres are meant, each with its key in a mapping and its size in metres."""


def column_units(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which one column of the measured points is in another unit, or was converted to metres once too often."""
    file = kind_of(dataset).format.measured_in
    names = ("x", "z") if dataset.points.shape[-1] == 2 else ("x", "y", "z")
    if not len(dataset.points):
        return
    for k, name in enumerate(names):
        others = " and ".join(other for other in names if other != name)
        for unit, key, size in _UNITS:
            for factor, says, remedy in (
                (
                    size,
                    f"the column {name} is in {unit}, and {others} in metres",
                    f"write {name} in metres, as {others}; where 'scalar import' made the table, write unit: {key} for {name} in the mapping",
                ),
                (
                    1.0 / size,
                    f"the column {name} is {1.0 / size:.4g} times too small beside {others}, as if it had been in {unit} and was in metres",
                    f"write {name} in metres, as {others}; where 'scalar import' made the table, correct the unit of {name} in the mapping",
                ),
            ):
                factors = np.ones(len(names))
                factors[k] = factor
                yield Alternative(
                    "length_unit",
                    file,
                    says,
                    f"with {name} multiplied by {factor:.6g}",
                    remedy,
                    replace(dataset, points=dataset.points * factors),
                )
