"""Another of several targets that sits where the first is stated to be: their names are exchanged, or ``nominal_pose`` belongs to the other."""

from __future__ import annotations

import numpy as np

from scalar.estimation.model import Model
from scalar.geometry.se3 import Array
from scalar.sensors import on_flange
from scalar.units import MM

APART = 50 * MM  # of the first target from its stated place: a mount is measured by hand to less
NEARER = 0.3  # of that distance: another target as near to the stated place is rather the one that is meant


def nearer_target(model: Model, T_flange_sensor: Array) -> str:
    """Return what is suspected if another target sits where the first is stated to be, and what to do; empty if none does.

    Args:
        model: As fitted.
        T_flange_sensor: ``(4, 4)``, the stated pose of the first target.
    """
    targets = on_flange(model.target)
    if targets is None or len(targets.names) < 2 or not targets.names[0]:
        return ""
    stated = T_flange_sensor[:3, 3]
    off = np.linalg.norm((model.T_flange_sensor @ targets.transforms)[:, :3, 3] - stated, axis=1)
    nearest = int(np.argmin(off))
    if off[0] < APART or off[nearest] > NEARER * off[0]:
        return ""
    first, other = targets.names[0], targets.names[nearest]
    return (
        f"the target '{first}', the first of points.csv, sits {off[0] / MM:.0f} mm from where nominal_pose has it, and '{other}' sits "
        f"{off[nearest] / MM:.0f} mm from there: look whether the two names are exchanged in points.csv, or whether nominal_pose belongs to the other"
    )
