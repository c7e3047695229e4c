"""All measured positions too long or too short by one factor, as where a camera was told another size of its board than it has.

A fit whose lengths are free takes up a factor near 1, and is then said to be stretched (``scalar.estimation.setup.arm.lengths``). Where orientations
are measured as well, or the factor is large, it does not, and the factor is looked for here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.length_units import is_ratio_of_units
from scalar.estimation.setup.trial import quick_fit, thinned
from scalar.sensors import kind_of
from scalar.units import MM

_WITHIN = 2.0  # chosen: the factor is looked for up to so many times more and less than the ratio of the spreads of positions
_SEARCHED_TO = 1e-3  # of the logarithm of the factor
# Relative, chosen: a factor nearer to 1 is taken up by the lengths of the arm.
_LEAST = 0.01
# Chosen: a camera before a board errs by some millimetres, and a wrong factor leaves centimetres.
_MAY_LEAVE = 10 * MM
_LIKE_A_UNIT = 0.02  # relative, chosen: a factor that is as near to the ratio of two units is one of these, and other alternatives say so


def measured_scale(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which all positions of a tracker or camera are measured too long or too short by one factor, if one fits best."""
    if dataset.planes or not len(dataset.points):
        return
    some = thinned(dataset)
    measured = float(np.sqrt(np.sum(np.var(some.points, axis=0))))
    flange = some.robot.flange(some.q)[:, :3, 3]
    if measured == 0.0 or not np.any(np.var(flange, axis=0)):
        return
    start = np.log(np.sqrt(np.sum(np.var(flange, axis=0))) / measured)

    def left(log_factor: float) -> float:
        """Return what a fit leaves [m], relative to the positions that it has: a small factor leaves little of anything."""
        factor = float(np.exp(log_factor))
        return quick_fit(replace(some, points=factor * some.points))[0].rms / factor

    bounds = (start - np.log(_WITHIN), start + np.log(_WITHIN))
    found = minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": _SEARCHED_TO})
    factor = float(np.exp(found.x))
    if abs(factor - 1) < _LEAST or is_ratio_of_units(factor, _LIKE_A_UNIT):
        return
    size = "large" if factor < 1 else "small"
    yield Alternative(
        "length_scale",
        kind_of(dataset).format.measured_in,
        f"all measured positions are {max(factor, 1 / factor):.3g} times too {size}",
        f"with them multiplied by {factor:.4g}",
        "look at the size of the board's squares or of the marker that the camera was told, and at the scale of the instrument; or multiply the "
        "positions by this factor",
        replace(dataset, points=factor * dataset.points),
        scale=factor,
        may_leave=_MAY_LEAVE,
    )
