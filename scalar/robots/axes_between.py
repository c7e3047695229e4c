"""What is the same in every table of joints of one arm, whatever its convention: distances and angles between successive joint axes, and offsets.

The frames of base and flange, zeros and signs of joints, and the place of d among parallel axes are choices of a table. Left are the length of the
common normal of two successive axes, the angle between them, and the offset between two such normals along an axis, or along a run of parallel axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from scalar.geometry.parallel_axes import near_parallel
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.units import DEG, MM

# Chosen: versions of an arm differ by more; the errors of one arm, and frames that are moved for convenience, differ by less.
FAR = 20 * MM
# The same for an angle between axes: those of arms are multiples of 45 degrees, and hardly any is 30.
TURNED = 10 * DEG
_A, _ALPHA, _D = (GEOMETRY.index(kind) for kind in ("a", "alpha", "d"))


@dataclass(frozen=True)
class BetweenAxes:
    """One distance or angle that does not depend on the convention.

    Attributes:
        what: What it is, as a person names it: ``the distance between axes 2 and 3``.
        value: Its size [m, rad].
        is_angle: Whether it is an angle.
    """

    what: str
    value: float
    is_angle: bool = False

    @property
    def in_words(self) -> str:
        """Return the size with its unit."""
        return f"{self.value / DEG:.0f} degrees" if self.is_angle else f"{self.value / MM:.4g} mm"


@lru_cache(maxsize=64)
def between_axes(robot: Robot) -> tuple[BetweenAxes, ...]:
    """Return the distances and angles between the axes of an arm, and its offsets, those of the first joints first."""
    a, alpha, d = (robot.geometry[k].tolist() for k in (_A, _ALPHA, _D))
    found: list[BetweenAxes] = []
    for i in range(1, robot.n_joints):
        axes = f"axes {i} and {i + 1}"
        found.append(BetweenAxes(f"the distance between {axes}", abs(a[i])))
        angle = math.acos(min(abs(math.cos(alpha[i])), 1.0))
        found.append(BetweenAxes(f"the angle between {axes}", angle, is_angle=True))
    for run in _parallel_runs(robot):
        if run[0] == 0 or run[-1] == robot.n_joints - 1 or not set(robot.prismatic).isdisjoint(run):
            continue  # the place of base and flange, or of a travel, is a choice
        offset, along = d[run[0]], 1.0
        for i in run[1:]:
            along *= math.copysign(1.0, math.cos(alpha[i]))
            offset += along * d[i]
        numbers = [str(i + 1) for i in run]
        axis = f"axis {numbers[0]}" if len(run) == 1 else f"axes {numbers[0]} to {numbers[-1]}"
        found.append(BetweenAxes(f"the offset along {axis}", abs(offset)))
    return tuple(found)


def _parallel_runs(robot: Robot) -> list[list[int]]:
    """Return the joints, from 0, in runs of successive axes that are nearly parallel."""
    runs: list[list[int]] = []
    for i, parallel in enumerate(near_parallel(robot)):
        if parallel:
            runs[-1].append(i)
        else:
            runs.append([i])
    return runs


def largest_difference(robot: Robot, other: Robot) -> tuple[float, BetweenAxes, BetweenAxes] | None:
    """Return by how much two arms differ most, in units of ``FAR`` and ``TURNED``, and in what: the value of each; None if it cannot be compared.

    Args:
        robot: An arm.
        other: An arm with as many joints; with another number, or with other axes parallel, only what both have is compared.
    """
    values = {value.what: value for value in between_axes(other)}
    pairs = [(value, values[value.what]) for value in between_axes(robot) if value.what in values]
    if robot.n_joints != other.n_joints or not pairs:
        return None
    sizes = [abs(one.value - two.value) / (TURNED if one.is_angle else FAR) for one, two in pairs]
    k = sizes.index(max(sizes))
    return sizes[k], *pairs[k]
