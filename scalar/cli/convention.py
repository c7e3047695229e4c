"""The option ``--mapping``: joint angles as the controller counts them, and the lines that say so."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.options import PATH
from scalar.data.formats import IMPORTED

if TYPE_CHECKING:
    from scalar.data.joint_convention import JointConvention
    from scalar.geometry.robot import Robot

MAPPING = click.option(
    "--mapping",
    type=PATH,
    metavar="MAPPING",
    help="The mapping of `scalar import`: joint angles are then those of the controller, as its keys plus, minus, sign and offset say.",
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


def lines_on_convention(
    convention: JointConvention | None, tables: str, imported: Mapping[str, str], arm: str
) -> list[str]:
    """Return the line on whose joint angles stand in the tables; none if those of the dataset are not known to differ from the controller's.

    Args:
        convention: How the controller counts the joints, by ``--mapping``; None without it.
        tables: Which tables have them, in words with their verb.
        imported: What the import knew, as ``Dataset.imported`` has it; empty if there was none.
        arm: Name of the arm; the library knows how some controllers count.
    """
    if convention is None:
        return _lines_without_mapping(tables, imported, arm)
    if not convention.in_words:
        return [
            f"  {convention.file} converts no joint: those of the controller count as those of the dataset"
        ]
    return [
        f"  {tables} the joint angles of the controller ({convention.in_words}, by {convention.file}); lines about limits name these too, and lines "
        "about measured ranges and singularities those of the dataset"
    ]


def _lines_without_mapping(tables: str, imported: Mapping[str, str], arm: str) -> list[str]:
    """Return the line that the tables have the angles of the dataset, where the controller is known to show others; arguments as above."""
    from scalar.robots.library import resembling

    if "joints" in imported:
        mapping = imported["mapping"]
        return [
            f"  without --mapping, {tables} the joint angles of the dataset, and not those that the controller shows ({imported['joints']}, "
            f"as {mapping} converted them): for those of the controller, give --mapping {mapping}"
        ]
    for known in resembling(arm):
        if known.controller_joints:
            return [
                f"  without --mapping, {tables} the joint angles of the dataset, and not those that a controller of {known.maker} shows "
                f"({known.controller_joints}): convert them before the arm moves, or give --mapping with a mapping that does (of 'scalar import "
                "--example FOLDER', for one)"
            ]
    return []


def imported_of(source: str) -> Mapping[str, str]:
    """Return ``imported`` of the dataset folder or dataset.yaml of this name; empty if there is none. Its other content was checked before."""
    from scalar.data.description import DESCRIPTION
    from scalar.data.io.plain_yaml import load_yaml

    path = Path(source)
    path = path / DESCRIPTION if path.is_dir() else path
    return load_yaml(path).get(IMPORTED, {}) if path.is_file() else {}
