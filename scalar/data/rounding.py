"""Whether joint angles or measurements were written with so few decimals that the rounding shows."""

from __future__ import annotations

import numpy as np

from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.units import DEG, MM

_STEPS = (
    (0.1, "0.1 rad"),
    (0.01, "0.01 rad"),
    (1 * DEG, "1 degree"),
    (0.1 * DEG, "0.1 degree"),
    (0.001, "0.001 rad"),
    (0.01 * DEG, "0.01 degree"),
)  # rad; the coarsest first
_EXACT_ANGLE = 1e-6  # rad: an angle that was rounded is a multiple of its step to this, also if it was converted and written with six decimals
_EXACT = 1e-6  # of a step: a coordinate that is written with few decimals is a multiple of it to this
_LEAST_SHARE = 0.05  # of a step at the end of the arm: rounding leaves 0.29 of a step at each joint, and the scans of a plane show a part of it
_LARGEST_SHARE = 0.5  # of the same: rounding leaves no more, however many joints there are
_MUCH_LARGER = 2.0  # steps: a residual beyond it has other causes than the rounding
_POINT_STEPS = ((1 * MM, "1 mm"), (0.1 * MM, "0.1 mm"))  # the coarsest first
_SEVERAL = 5  # different positions of a joint, or values of a coordinate: fewer are multiples of a step because there are few


def rounded_angles(robot: Robot, q: np.ndarray, residual: float) -> str:
    """Return a clause that says that all joint angles are multiples of a coarse step; empty if not, or if rounding explains no such residual.

    An arm may well be sent to whole degrees: then the residual is smaller than that of angles that were rounded, or has another cause and is larger.

    Args:
        robot: The arm; joints that slide are left out.
        q: ``(N, n)`` [rad; m of a joint that slides].
        residual: Root mean square of what the best fit leaves [m].
    """
    reach = float(np.abs(robot.geometry[[i for i, kind in enumerate(GEOMETRY) if kind in LENGTHS]]).sum())
    moved = [column for column in q[:, ~np.asarray(robot.slides)].T if len(np.unique(column)) >= _SEVERAL]
    for step, named in _STEPS if moved else ():
        if all(_are_multiples(column, step, _EXACT_ANGLE / step) for column in moved):
            suspicion = (
                f"every joint angle is a multiple of {named}: if they were rounded, each is off by up to {step / 2 / MM:.2g} mm at a distance of "
                "1 m; write them with all decimals"
            )
            return suspicion if _LEAST_SHARE * step * reach < residual < _LARGEST_SHARE * step * reach else ""
    return ""


def rounded_points(points: np.ndarray, residual: float) -> str:
    """Return a clause that says that all measured coordinates are multiples of a coarse step; empty if not, or if the residual is much larger.

    A target that returns to a few places whose coordinates are stated (a ball in one of two sockets) has few different coordinates, and these
    tell nothing of rounding.

    Args:
        points: ``(P, 2 or 3)`` [m].
        residual: Root mean square of what the best fit leaves [m].
    """
    for step, named in _POINT_STEPS:
        if (
            residual < _MUCH_LARGER * step
            and _are_multiples(points, step)
            and points.size > 0
            and all(len(np.unique(column)) >= _SEVERAL for column in points.T)
        ):
            return (
                f"every measured coordinate is a multiple of {named}: rounding them leaves {step / MM / 12**0.5:.2g} mm, which no calibration goes "
                "below; write them with all decimals"
            )
    return ""


def _are_multiples(values: np.ndarray, step: float, exact: float = _EXACT) -> bool:
    """Return whether all of some numbers are multiples of a step, to a share ``exact`` of it; the first few mostly show already that they are not."""
    return all(
        np.abs(some / step - np.round(some / step)).max(initial=0.0) < exact
        for some in (values[:_SEVERAL], values)
    )
