"""Lines about single poses of a table: the first few, and a count of the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.geometry.robot import Robot
    from scalar.geometry.se3 import Array

MOST_SHOWN = 10
"""Most poses that are listed one by one."""


def first_lines(lines: list[str]) -> list[str]:
    """Return the first lines, and one that counts the others."""
    more = len(lines) - MOST_SHOWN
    return [*lines[:MOST_SHOWN], f"  and {more} more poses likewise"] if more > 0 else lines


def lines_on_limits(robot: Robot, ids: Array, q: Array) -> list[str]:
    """Return a line for each of the first few poses at which a joint is beyond its limits, and one that counts the others.

    Args:
        robot: Whose limits count; a revolute joint without stated limits has half a turn on either side of zero.
        ids: ``(N,)``, numbers of the poses.
        q: ``(N, n)`` [rad; m of a joint that slides].
    """
    import numpy as np

    beyond = (q < robot.limits[:, 0]) | (q > robot.limits[:, 1])
    lines = []
    for i in np.flatnonzero(beyond.any(axis=1)):
        joint = int(np.argmax(beyond[i]))
        size, unit = (MM, "mm") if joint in robot.prismatic else (DEG, "deg")
        low, high = robot.limits[joint] / size
        lines.append(
            f"  pose {ids[i]}: joint {joint + 1} at {q[i, joint] / size:.3f} {unit} is beyond its limits {low:.1f} to {high:.1f} {unit}"
        )
    return first_lines(lines)
