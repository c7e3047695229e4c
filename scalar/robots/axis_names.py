"""What the maker of an arm calls the axes of its joints, so that a reader finds joint 4 of a table on the arm."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.geometry.robot import Robot
from scalar.robots.library import resembling
from scalar.robots.named_arm import doubt_of_name


def axis_names_of(robot: Robot) -> tuple[str, ...]:
    """Return the maker's names of the axes of all n joints; empty where the library does not know the arm, or cannot be sure that it is this one.

    An arm is recognised by its name. All arms of the library that this name may mean have to name their axes alike, with as many joints, and the
    table of joints must not clearly be that of another arm.

    Args:
        robot: The nominal robot, with the name that the dataset gives it.
    """
    found = {arm.axis_names for arm in resembling(robot.name)}
    if len(found) != 1:
        return ()
    (names,) = found
    return names if len(names) == robot.n_joints and not doubt_of_name(robot) else ()


def axis_in_brackets(names: Sequence[str], joints: Sequence[int]) -> str:
    """Return the names of the axes of some joints in brackets, with a blank before them, as in `` (S, L)``; empty where no names are known.

    Args:
        names: Those of all joints, or none.
        joints: Numbers of joints, from 1.
    """
    shown = [names[joint - 1] for joint in joints if 1 <= joint <= len(names)]
    return f" ({', '.join(shown)})" if shown else ""
