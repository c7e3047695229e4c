"""The scale of an arm where no length is known: a touch probe on planes of unknown place measures the arm's proportions only.

One length is then fixed at its data sheet's value, and every other length is relative to it. Its own error stretches the whole arm in proportion,
leaves no residual, and is in no covariance. It is estimated as the root mean square change of the lengths that were found, or is the maker's
tolerance where that is stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.estimation.fixed_parameter import NO_LENGTH_KNOWN
from scalar.estimation.result import Calibration


@dataclass(frozen=True)
class UnknownScale:
    """How uncertain the scale of an arm is.

    Attributes:
        name: Of the length that was fixed.
        std: Standard deviation of its error [m], estimated.
        length: Its value [m], positive.
    """

    name: str
    std: float
    length: float

    @property
    def relative(self) -> float:
        """Return the standard deviation of the scale, as a share of all lengths."""
        return self.std / self.length


def unknown_scale(calibration: Calibration) -> UnknownScale | None:
    """Return how uncertain the scale of a calibration is; None if its data determine the scale."""
    fixed = next((entry["held"] for entry in calibration.gauge if entry["reason"] == NO_LENGTH_KNOWN), None)
    robot, nominal = calibration.model.robot, calibration.model.nominal
    names = robot.parameter_names
    if fixed not in names:
        return None
    free = [name in calibration.free and name.startswith(("a_", "d_")) for name in names]
    change = (robot.geometry - nominal.geometry).ravel()[free]
    if nominal.tolerance is not None:
        std = nominal.tolerance.length
    elif len(change):
        std = float(np.sqrt(np.mean(change**2)))
    else:
        return None
    length = abs(float(robot.geometry.ravel()[names.index(fixed)]))
    return UnknownScale(fixed, std, length) if length > 0 else None
