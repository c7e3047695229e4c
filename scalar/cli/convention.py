"""The option ``--mapping``: joint angles as the controller counts them, and the lines that say so."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.options import PATH

if TYPE_CHECKING:
    from scalar.data.joint_convention import JointConvention
    from scalar.geometry.robot import Robot

MAPPING = click.option(
    "--mapping",
    type=PATH,
    metavar="MAPPING",
    help="The mapping of `scalar import`: joint angles are then those of the controller, as its keys plus, sign and offset say.",
)


def convention_of(mapping: Path | None, robot: Robot) -> JointConvention | None:
    """Return how the controller counts the joints of an arm by the mapping of ``--mapping``; None without it.

    Raises:
        InvalidInput: The mapping is at fault, or is for another arm.
    """
    if mapping is None:
        return None
    from scalar.ingest.controller_joints import controller_joints

    return controller_joints(mapping, robot.to_mapping())


def lines_on_convention(convention: JointConvention | None, tables: str) -> list[str]:
    """Return the line on whose joint angles stand in the tables, and which the other lines name; none without --mapping.

    Args:
        convention: How the controller counts the joints.
        tables: Which tables have them, in words with their verb.
    """
    if convention is None:
        return []
    if not convention.in_words:
        return [
            f"  {convention.file} converts no joint: those of the controller count as those of the dataset"
        ]
    return [
        f"  {tables} the joint angles of the controller ({convention.in_words}, by {convention.file}); lines about joints name those of the dataset"
    ]
