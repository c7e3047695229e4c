"""What a mapping file says: which column of a foreign table becomes which column of the dataset, in which unit, for which robot."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from scalar.data.description import Description
from scalar.data.formats import COMMANDED, PAYLOAD, TORQUE
from scalar.data.sensor_formats import MeasuredTable
from scalar.ingest.column_profiles import ColumnProfiles
from scalar.ingest.matching import NearestTime
from scalar.ingest.orientation import EULER, QUATERNION, VECTOR
from scalar.ingest.raw_table import Reference
from scalar.ingest.row_profiles import RowProfiles

TARGET = "target"
TEXT_COLUMNS = ("plane", "session", TARGET, "nest")
JOINT = re.compile(r"qc?[1-9][0-9]*")
OF_JOINT = re.compile(rf"(approach|{TORQUE})[1-9][0-9]*")
"""Columns whose sign is that of a joint's motion."""
APPROACH = re.compile(r"approach[1-9][0-9]*")
_BY_JOINT = re.compile(rf"(q|{COMMANDED}|{TORQUE})([1-9][0-9]*)")


@dataclass(frozen=True)
class Column:
    """How a column of the dataset is made: ``sign * (value + plus - minus) + offset``, in the file's unit, converted to SI.

    Attributes:
        reference: the column of the file.
        to_si: converts from the file's unit to SI.
        sign: 1 or -1.
        offset: in the file's unit.
        plus: a second column of the file, in the same unit, that is added to the first; None if there is none. Controllers that show a joint against
            the horizontal need it, or ``minus``.
        minus: such a column that is subtracted; None if there is none. A column has at most one of the two.
        names: for text, ``{value in the file: value in the dataset}``; None if all values are kept.
        unit: the file's unit; empty if the column has none.
        sign_stated: whether the mapping states ``sign``.
        values: for a direction of approach, ``{text in the file: 1, -1 or 0}``; None if the mapping states none.
    """

    reference: Reference
    to_si: Callable[[Any], Any]
    sign: float = 1.0
    offset: float = 0.0
    plus: Reference | None = None
    names: Mapping[str, str] | None = None
    unit: str = ""
    sign_stated: bool = False
    values: Mapping[str, float] | None = None
    minus: Reference | None = None

    @property
    def second(self) -> tuple[Reference, float] | None:
        """The column that is added to the first, and 1, or the one that is subtracted, and -1; None if there is neither."""
        if self.plus is not None:
            return self.plus, 1.0
        return None if self.minus is None else (self.minus, -1.0)


@dataclass(frozen=True)
class FileRule:
    """A file, or files by a pattern, and what holds for all their rows.

    Attributes:
        name: name of the file, or a pattern of names; once a file is chosen, what messages call it.
        text: columns of text, such as ``plane`` and ``session``, that have one value in the whole file.
        covariates: columns of numbers that have one value in the whole file.
        first_pose: the id of its first pose, if ids are counted; None if they continue those of the file before.
        add_to_pose: what is added to the numbers of its poses, where each file counts them from the beginning.
    """

    name: str
    text: Mapping[str, str]
    covariates: Mapping[str, float]
    first_pose: int | None = None
    add_to_pose: int = 0


@dataclass(frozen=True)
class Block:
    """How one table of the dataset is made: poses, points or nests.

    Attributes:
        columns: the columns by their names in the dataset, covariates among them.
        files: the files to read; empty if all files given are read.
        drop_without: columns of the dataset; a row in which one of them is empty is left out.
        first_of_each: the file's column whose value identifies the pose, if a pose has several rows.
        euler_axes: the axes about which the columns e1,e2,e3 turn; None if there are no such columns.
        text: how its text files are written, where the mapping says so for this block alone.
        row_profiles: where the values of the profiles stand, if each row of the files is a whole profile; else None.
        column_profiles: the same, if each column is one.
        rows_per_pose: how many successive rows belong to each pose, where no column says it; else None.
        drop_zeros: columns of the dataset; a row in which all of them are exactly 0 is left out.
        rows_like: ``{column of the file: pattern}``; a row whose cell is not like the pattern is left out.
        matched_only: for points: whether poses without points and points without a pose are left out.
        nearest_time: for points: how they are given to poses by their time; None if a column says to which pose they belong.
        targets: if a row measures several targets, the columns of each target by its name; ``columns`` are then those that all have in common.
        rows_in_order: for poses: whether rows and files are stated to be in the order in which they were measured.
    """

    columns: Mapping[str, Column]
    files: tuple[FileRule, ...]
    drop_without: tuple[str, ...]
    first_of_each: Reference | None
    euler_axes: str | None = None
    text: Mapping[str, Any] = field(default_factory=dict)
    row_profiles: RowProfiles | None = None
    column_profiles: ColumnProfiles | None = None
    rows_per_pose: int | None = None
    targets: Mapping[str, Mapping[str, Column]] = field(default_factory=dict)
    rows_like: Mapping[str, str] = field(default_factory=dict)
    matched_only: bool = False
    nearest_time: NearestTime | None = None
    drop_zeros: tuple[str, ...] = ()
    rows_in_order: bool = False

    @property
    def column_names(self) -> list[str]:
        """Return the columns of the dataset that it gives, those of targets among them, without those that are the same in a whole file."""
        of_targets = [name for columns in self.targets.values() for name in columns]
        return list(dict.fromkeys([*self.columns, *of_targets, *([TARGET] if self.targets else [])]))

    def of_each_target(self) -> list[tuple[Self, dict[str, str]]]:
        """Return a block for each target of a row, with the text columns that name the target; the block itself without several targets in a row."""
        if not self.targets:
            return [(self, {})]
        return [
            (replace(self, columns={**self.columns, **columns}, targets={}), {TARGET: name})
            for name, columns in self.targets.items()
        ]


@dataclass(frozen=True)
class MappingFile:
    """The content of a mapping file that has no fault.

    Attributes:
        description: the content of the dataset.yaml to be written, in SI, checked.
        text: how text files are written, as its block ``text`` says.
        variable: name of the matrix in a .mat file, or None.
        poses: how the table of poses is made.
        points: how the table of points is made; None if they are in the files of the poses.
        nests: how the table of points fixed to the base is made, or None.
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
        """Return the further columns that the sensor's table may have."""
        return () if self.table is None else self.table.further

    @property
    def foreign_points(self) -> tuple[str, ...]:
        """Return the columns that a foreign table may have instead of a rotation vector: Euler angles and quaternions."""
        return (*EULER, *QUATERNION) if VECTOR[0] in self.further_points else ()

    @property
    def references(self) -> MeasuredTable | None:
        """Return the table of points fixed to the base that the sensor may have, or None."""
        return None if self.description.sensor_format is None else self.description.sensor_format.references

    @property
    def measured_columns(self) -> tuple[str, ...]:
        """Return the columns of the sensor's table that this mapping gives: the coordinates, and the further columns that it names."""
        columns = set((self.poses if self.points is None else self.points).column_names)
        if columns & {*EULER, *QUATERNION}:
            columns |= set(VECTOR)
        return (*self.point_columns, *(name for name in self.further_points if name in columns))

    @property
    def table(self) -> MeasuredTable | None:
        """Return the table that the sensor needs, or None."""
        return None if self.description.sensor_format is None else self.description.sensor_format.table

    def measured_in(self, block: Block) -> tuple[str, ...]:
        """Return the coordinates that a block may have: those of the nests, or those that the sensor needs."""
        if block is self.nests and self.references is not None:
            return tuple(self.references.units)
        return self.point_columns

    @property
    def several_points(self) -> bool:
        """Return whether each row of the block ``poses`` is a point, of which a pose has several."""
        if self.table is None or self.points is not None:
            return False
        return self.table.several_rows or self.table.item in self.poses.columns


def quantity_of(name: str, table: MeasuredTable | None, description: Description) -> str | None:
    """Return the quantity that a column of the dataset holds, such as ``length``, or None if it has no unit.

    Args:
        name: Name of the column.
        table: The table of the sensor's measurements, which states their units; None if the sensor has no such table.
        description: The description of the dataset, which says which joints are prismatic.
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
