"""What a mapping file says: which column of a foreign table becomes which of ours, in which unit, for which robot."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from scalar.data.description import Description
from scalar.data.formats import COMMANDED, PAYLOAD, TORQUE
from scalar.data.sensor_formats import MeasuredTable
from scalar.ingest.orientation import EULER, QUATERNION, VECTOR
from scalar.ingest.raw_table import Reference

TEXT_COLUMNS = ("plane", "session", "target", "nest")
JOINT = re.compile(r"qc?[1-9][0-9]*")
_BY_JOINT = re.compile(rf"(q|{COMMANDED}|{TORQUE})([1-9][0-9]*)")


@dataclass(frozen=True)
class Column:
    """Where one of our columns comes from: ``ours = sign * theirs + offset``, in their unit, then in SI.

    Attributes:
        reference: the column of the file.
        to_si: from the file's unit to SI.
        sign: 1 or -1.
        offset: in the file's unit.
        names: for text: what the file's values are called here; None where they stay.
    """

    reference: Reference
    to_si: Callable[[Any], Any]
    sign: float = 1.0
    offset: float = 0.0
    names: Mapping[str, str] | None = None


@dataclass(frozen=True)
class FileRule:
    """A file, or files by a pattern, and what holds for all their rows.

    Attributes:
        name: of the file, or a pattern of names.
        text: plane and session, where they are the same in the whole file.
        covariates: numbers that are the same in the whole file.
        first_pose: the id of its first pose where ids are counted; None: they go on from the file before.
    """

    name: str
    text: Mapping[str, str]
    covariates: Mapping[str, float]
    first_pose: int | None = None


@dataclass(frozen=True)
class Block:
    """A table to be made: of poses or of points.

    Attributes:
        columns: by our name, covariates among them.
        files: empty where every file given is meant.
        drop_without: our columns without which a row is left out.
        first_of_each: the file's column that tells the poses apart where a pose has several rows.
        euler_axes: about which the columns e1,e2,e3 turn; None where there are none.
    """

    columns: Mapping[str, Column]
    files: tuple[FileRule, ...]
    drop_without: tuple[str, ...]
    first_of_each: Reference | None
    euler_axes: str | None = None


@dataclass(frozen=True)
class MappingFile:
    """A mapping without a fault.

    Attributes:
        description: the content of dataset.yaml to be, in SI, checked.
        text: how text files are written.
        variable: of a .mat file.
        poses: the table of poses.
        points: the table of points, where it is in files of its own.
        nests: the table of points fixed to the base, or None.
    """

    description: Description
    text: Mapping[str, Any]
    variable: str | None
    poses: Block
    points: Block | None
    nests: Block | None = None

    @property
    def point_columns(self) -> tuple[str, ...]:
        """Return the coordinates that the sensor needs: ``x, z``, ``x, y, z`` or none."""
        return () if self.table is None else tuple(self.table.units)

    @property
    def further_points(self) -> tuple[str, ...]:
        """Return the columns that the sensor's table may have beside these."""
        return () if self.table is None else self.table.further

    @property
    def foreign_points(self) -> tuple[str, ...]:
        """Return the columns that stand for some of these in foreign tables: Euler angles and quaternions."""
        return (*EULER, *QUATERNION) if VECTOR[0] in self.further_points else ()

    @property
    def references(self) -> MeasuredTable | None:
        """Return the table of points fixed to the base that the sensor may have, or None."""
        return None if self.description.format is None else self.description.format.references

    @property
    def measured_columns(self) -> tuple[str, ...]:
        """Return the columns of the sensor's table that this mapping gives: the coordinates, and those of the further ones that it names."""
        columns = set((self.poses if self.points is None else self.points).columns)
        if columns & {*EULER, *QUATERNION}:
            columns |= set(VECTOR)
        return (*self.point_columns, *(name for name in self.further_points if name in columns))

    @property
    def table(self) -> MeasuredTable | None:
        """Return the table that the sensor needs, or None."""
        return None if self.description.format is None else self.description.format.table

    @property
    def several_points(self) -> bool:
        """Return whether the rows of the poses are points, several a pose."""
        if self.table is None or self.points is not None:
            return False
        return self.table.several_rows or self.table.item in self.poses.columns


def quantity_of(name: str, table: MeasuredTable | None, description: Description) -> str | None:
    """Return the quantity in a column of ours that has a unit, or None.

    Args:
        name: Of the column.
        table: Of the kind of sensor, which says the units of what it measures; None where it measures nothing of its own.
        description: Says which joints slide.
    """
    found = _BY_JOINT.fullmatch(name)
    if found:
        slides = description.slides(int(found[2]) - 1)
        if found[1] == TORQUE:
            return "force" if slides else "torque"
        return "length" if slides else "angle"
    if name in EULER:
        return "angle"
    if name in PAYLOAD:
        return "mass" if name == PAYLOAD[0] else "length"
    if table is not None and name in (units := {**table.units, **table.optional}):
        return {"m": "length", "rad": "angle"}[units[name]]
    return {"time": "time", "temperature": "temperature"}.get(name)
