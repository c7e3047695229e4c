"""Units of length that are mistaken for one another."""

from __future__ import annotations

import numpy as np

LENGTH_UNITS = {"inches": 25.4, "metres": 1000.0, "centimetres": 10.0, "feet": 304.8}
"""Units that are mistaken for millimetres or metres, each with its size in millimetres."""
WITH_MILLIMETRES = {"millimetres": 1.0, **LENGTH_UNITS}
"""The same, and millimetres."""


def is_ratio_of_units(factor: float, within: float) -> bool:
    """Return whether two units have this ratio; ``within`` is by how much its logarithm may differ."""
    sizes = np.array(list(WITH_MILLIMETRES.values()))
    return bool(np.any(np.abs(np.log(factor * sizes[:, None] / sizes)) < within))
