"""Whether a table of joints is that of the library's arm whose name it bears: a doubt where it clearly differs, since a name proves nothing."""

from __future__ import annotations

from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.standard_dh import read_as_modified, read_as_standard
from scalar.robots.axes_between import FAR, BetweenAxes, between_axes, largest_difference
from scalar.robots.library import LibraryArm, arm_names, read_arm, resembling
from scalar.units import MM

_FITS = 5 * MM
"""Most by which a distance between the axes of a measured arm may differ from that of its data sheet; versions of a model differ by 10 mm or more."""
_AS_CLOSE = 1 * MM
"""An arm whose largest difference is greater than the least by no more than this is named as well: models of one make may have the same axes."""


def doubt_of_name(robot: Robot) -> str:
    """Return a sentence if a robot's name resembles arms of the library, and its table of joints is clearly that of none of them; else nothing."""
    compared = [
        (*difference, arm)
        for arm in resembling(robot.name)
        if (difference := largest_difference(robot, arm.robot))
    ]
    if not compared:
        return ""
    size, own, listed, arm = min(compared, key=lambda found: found[0])
    return "" if size <= 1.0 else _sentence(robot, own, listed, arm)


def arms_with_axes_of(robot: Robot) -> list[LibraryArm]:
    """Return the arms of the library whose axes stand to one another as those of a calibrated arm do, the closest first; none if none fits."""
    arms = [read_arm(name) for name in arm_names()]
    compared = [
        (difference[0] * FAR, arm) for arm in arms if (difference := largest_difference(robot, arm.robot))
    ]
    compared.sort(key=lambda found: found[0])
    return [arm for size, arm in compared if size <= min(_FITS, compared[0][0] + _AS_CLOSE)]


def arms_in_proportion(robot: Robot) -> list[tuple[float, LibraryArm]]:
    """Return the arms of the library whose axes are those of a calibrated arm times one factor, with this factor, the closest first.

    Where no length is known, the data show the proportions of an arm and not its size.
    """
    own = {value.what: value.value for value in between_axes(robot) if not value.is_angle}
    compared: list[tuple[float, float, LibraryArm]] = []
    for arm in (read_arm(name) for name in arm_names()):
        pairs = [(own[v.what], v.value) for v in between_axes(arm.robot) if not v.is_angle and v.what in own]
        square = sum(mine**2 for mine, _ in pairs)
        factor = sum(mine * theirs for mine, theirs in pairs) / square if square else 0.0
        if factor and (difference := largest_difference(_times(robot, factor), arm.robot)):
            compared.append((difference[0] * FAR, factor, arm))
    compared.sort(key=lambda found: found[0])
    return [(factor, arm) for size, factor, arm in compared if size <= min(_FITS, compared[0][0] + _AS_CLOSE)]


def _times(robot: Robot, factor: float) -> Robot:
    """Return an arm with all lengths of its joints multiplied by a factor."""
    geometry = robot.geometry.copy()
    geometry[[kind in LENGTHS for kind in GEOMETRY]] *= factor
    return robot.with_geometry(geometry)


def _sentence(robot: Robot, own: BetweenAxes, listed: BetweenAxes, arm: LibraryArm) -> str:
    """Return the doubt: what differs, and whether the other convention would remove the difference."""
    convention, read = (
        ("modified-dh", read_as_modified) if robot.standard_dh else ("standard-dh", read_as_standard)
    )
    found = largest_difference(read(robot), arm.robot)
    ask = (
        f"under `convention: {convention}` it would be that arm's; is the convention stated wrongly?"
        if found is not None and found[0] <= 1.0
        else "is a number mistyped? If this is another version or another robot, the name does no harm"
    )
    return (
        f"the robot is called '{robot.name}', but its table of joints is not that of {arm.maker} {arm.model} in the library: "
        f"{own.what} is {own.in_words} and not {listed.in_words}; {ask}"
    )
