"""Columns of scans that may be exchanged or count the other way, judged by where a fit has the scanner on the flange.

Points of a scan lie in a plane, so that exchanged or mirrored columns describe the same scan in a scanner whose axes are turned. The fit leaves no
residual, and has the scanner turned by half a turn.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array, log_so3
from scalar.units import DEG

PLAUSIBLE = 30 * DEG  # from nominal_pose, which may be wrong by as much

AXES = (
    ("the columns x and z of {file} may be swapped", np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])),
    ("the column x of {file} may count the other way", np.diag([-1.0, -1.0, 1.0])),
    ("the column z of {file} may count the other way", np.diag([1.0, -1.0, -1.0])),
)  # fmt: skip
"""What may be wrong, and the axes of the scanner as the wrong columns show it in its true frame: ``R_fitted = R_true S``."""


def misread_axes(R_nominal: Array, R_fitted: Array, file: str) -> str | None:
    """Return which columns of scans would have the scanner where it is stated if they were read otherwise, with the angle; None if none would.

    Args:
        R_nominal: ``(3, 3)``, orientation of the scanner on the flange as stated.
        R_fitted: ``(3, 3)``, the same as fitted.
        file: The table of the scans.
    """
    turns = [float(np.linalg.norm(log_so3(R_nominal.T @ R_fitted @ S.T))) for _, S in AXES]
    best = int(np.argmin(turns))
    if turns[best] > PLAUSIBLE:
        return None
    return f"{AXES[best][0].format(file=file)}: read so, the scans put the scanner {turns[best] / DEG:.0f} degrees from nominal_pose"
