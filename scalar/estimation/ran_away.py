"""Which parameters of a fit are farther from the data sheet than those of any real arm: such a fit describes another arm."""

from __future__ import annotations

import numpy as np

from scalar.estimation.model import Model
from scalar.estimation.settings import DEFAULTS, FitSettings
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.units import DEG, MM


def ran_away(model: Model, settings: FitSettings = DEFAULTS.fit) -> list[tuple[str, float, float, str]]:
    """Return the parameters that are implausibly far from the data sheet: name, change, bound, and the unit of both."""
    change = np.abs(model.robot.geometry - model.nominal.geometry)
    found: list[tuple[str, float, float, str]] = []
    for k, kind in enumerate(GEOMETRY):
        bound, size, unit = (
            (settings.largest_length_change, MM, "mm")
            if kind in LENGTHS
            else (settings.largest_angle_change, DEG, "deg")
        )
        found += [
            (f"{kind}_{i + 1}", float(change[k, i]) / size, bound / size, unit)
            for i in np.flatnonzero(change[k] > bound)
        ]
    return found
