"""Another arm of the library than the one that dataset.yaml describes, which is tried where no correction of the stated table explains the data.

The nominal arm that was measured leaves a millimetre or two with sensor and target fitted, and one of another length leaves centimetres. Only the
nearest arm is proposed, and only if its axes are still those of the library once its own geometry is fitted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_robot
from scalar.estimation.setup.trial import nominal_fit, thinned
from scalar.geometry.robot import Robot
from scalar.robots import LibraryArm, arm_names, arms_with_axes_of, read_arm
from scalar.robots.axes_between import largest_difference
from scalar.units import MM

OTHER_ARM = "other_arm"  # as an alternative names it
NEAREST = 5 * MM
"""Most that the nominal arm may leave (median of the poses): real arms err by less, and arms of a few centimetres more or less length by more."""


def other_arms(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which the arm of the library that fits best was measured, if it fits as a nominal arm does."""
    few = thinned(dataset)  # once, and not for each arm
    nominals = [
        (nominal_fit(replace(few, robot=robot)).rms, arm, robot)
        for arm in map(read_arm, arm_names())
        if (robot := _in_place_of(dataset.robot, arm)) is not None
    ]
    if not nominals:
        return
    least, arm, robot = min(nominals, key=lambda nominal: nominal[0])
    if least > NEAREST:
        return
    alike = {one.name for one in arms_with_axes_of(arm.robot)}
    named = [one for rms, one, _ in nominals if one.name in alike and rms <= NEAREST]
    yield with_robot(
        dataset,
        robot,
        OTHER_ARM,
        "robot",
        f"the table of joints is not that of the arm that was measured{_difference(dataset.robot, arm)}; "
        f"{' or '.join(f'{one.maker} {one.model} ({one.name!r} of the library)' for one in named)} fits",
        "with its table",
        f"if that is your arm, begin its folder by `scalar init --robot {arm.name}`; else correct the lengths of robot.joints",
    )


def _difference(robot: Robot, arm: LibraryArm) -> str:
    """Return in what the described arm differs most from an arm of the library, in brackets; nothing if the two cannot be compared."""
    found = largest_difference(robot, arm.robot)
    return (
        ""
        if found is None
        else f" ({found[1].what} is {found[1].in_words} there and should be {found[2].in_words})"
    )


def stays_that_arm(alternative: Alternative, fitted: Robot) -> bool:
    """Return whether an arm of the library, once fitted, still has the axes that the library states; true of all other alternatives."""
    if alternative.what != OTHER_ARM:
        return True
    return alternative.dataset.robot.name in [arm.name for arm in arms_with_axes_of(fitted)]


def _in_place_of(robot: Robot, arm: LibraryArm) -> Robot | None:
    """Return an arm of the library where the described one stands; None if it has another number of joints, or others that slide."""
    own = arm.robot
    if own.n_joints != robot.n_joints or own.prismatic != robot.prismatic:
        return None
    return replace(own, T_base_0=robot.T_base_0, gravity=robot.gravity, tolerance=robot.tolerance)
