"""Whether two tables of joints are those of one arm.

Tables of one arm may be rounded differently, and an angle may be written with a full turn more or less. The transforms of base and flange are left
out: another pedestal or another tool does not make another arm.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.standard_dh import as_stated

_ROUNDED = 1e-3  # m or rad: tables of one arm that are rounded differ by less


def difference_of_arms(there: Robot, here: Robot) -> str | None:
    """Return in words what shows that two nominal arms are not the same arm; None where nothing shows it.

    Args:
        there: The arm of a calibration.
        here: The arm of a dataset, by whose name the words call it.
    """
    if there.n_joints != here.n_joints:
        return f"it calibrates an arm with {there.n_joints} joints, and '{here.name}' has {here.n_joints}"
    sliding = np.flatnonzero(there.slides != here.slides)
    if sliding.size:
        first = int(sliding[0])
        which = "slides there and turns" if there.slides[first] else "turns there and slides"
        return f"it calibrates another arm: joint {first + 1} {which} in the table of '{here.name}'"
    off = np.abs(there.geometry - here.geometry)
    for k, kind in enumerate(GEOMETRY):
        if kind not in LENGTHS:
            off[k] = np.abs((off[k] + np.pi) % (2.0 * np.pi) - np.pi)
    if off.max(initial=0.0) <= _ROUNDED:
        return None
    k = int(off.argmax())
    values = f"{there.geometry.ravel()[k]:.6g} there and {here.geometry.ravel()[k]:.6g} in the table of '{here.name}'"
    return f"it calibrates another arm: nominal {as_stated(here.parameter_names[k], here)} is {values}"
