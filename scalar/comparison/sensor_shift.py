"""How far the sensor stands elsewhere on the flange in the later of two calibrations, and whether chance explains it.

The places are those that the calibrations report, with the same parameters of the arm fixed (the length of the last link, for one, is confounded with
the place of the sensor). If they fix different ones, a part of the distance belongs to these, and no standard error is stated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2

from scalar.estimation.model import SENSOR_PARAMETERS
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.units import MM

_PLACE = SENSOR_PARAMETERS[:3]


@dataclass(frozen=True)
class SensorShift:
    """The distance between the places of the sensor on the flange.

    Attributes:
        distance: [m].
        std: Standard error [m] along the shift; None if the two calibrations fix different parameters, or no coordinate of the place is free.
        p_value: Probability that chance makes a shift as large; None likewise.
    """

    distance: float
    std: float | None = None
    p_value: float | None = None

    @classmethod
    def between(cls, a: Calibration, b: Calibration) -> SensorShift:
        """Return the shift from calibration A to B, of campaigns whose errors are independent."""
        shift = b.model.T_flange_sensor[:3, 3] - a.model.T_flange_sensor[:3, 3]
        distance = float(np.linalg.norm(shift))
        free = [name in a.free for name in _PLACE]
        if _fixed_of_arm(a) != _fixed_of_arm(b) or not any(free):
            return cls(distance)
        covariance = _covariance_of_place(a) + _covariance_of_place(b)
        along = shift / distance if distance else np.array(free) / np.sqrt(sum(free))
        std = float(np.sqrt(along @ covariance @ along))
        of_free = shift[free] @ np.linalg.pinv(covariance[np.ix_(free, free)]) @ shift[free]
        return cls(distance, std, float(chi2.sf(of_free, sum(free))))

    def to_mapping(self) -> dict[str, Any]:
        """Return its entries of ``campaign`` in ``comparison.json``."""
        return {
            "sensor_shift_mm": self.distance / MM,
            "sensor_shift_std_mm": None if self.std is None else self.std / MM,
            "sensor_shift_p_value": self.p_value,
        }


def _fixed_of_arm(calibration: Calibration) -> set[str]:
    """Return the names of the parameters of arm and sensor that are fixed, without the turn of the sensor, which a tracker does not show."""
    model = calibration.model
    of_arm = [*model.names[model.blocks["geometry"]], *_PLACE]
    return {name for name in of_arm if name not in calibration.free}


def _covariance_of_place(calibration: Calibration) -> Array:
    """Return the covariance ``(3, 3)`` [m^2] of the sensor's place on the flange; zero where a coordinate is fixed."""
    found = np.zeros((3, 3))
    at = [(i, calibration.free.index(name)) for i, name in enumerate(_PLACE) if name in calibration.free]
    own, of_free = ([pair[k] for pair in at] for k in (0, 1))
    found[np.ix_(own, own)] = calibration.covariance[np.ix_(of_free, of_free)]
    return found
