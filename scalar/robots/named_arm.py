"""Whether a table of joints is that of the library's arm whose name it bears: a doubt where it clearly differs, since a name proves nothing."""

from __future__ import annotations

from scalar.geometry.robot import Robot
from scalar.geometry.standard_dh import read_as_modified, read_as_standard
from scalar.robots.axes_between import BetweenAxes, largest_difference
from scalar.robots.library import LibraryArm, resembling


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
