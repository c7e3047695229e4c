"""Read the table that a block of a mapping describes (poses, points or nests) from its foreign files, in SI."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.alike_faults import named_once
from scalar.ingest.column_profiles import points_of_columns
from scalar.ingest.copied_files import FileRead, digest_of, report_copies
from scalar.ingest.file_columns import read_columns
from scalar.ingest.foreign_tables import read_raw
from scalar.ingest.imported_table import ImportedTable, joined, select_rows
from scalar.ingest.left_out import LeftOut
from scalar.ingest.mapping import JOINT, Block, FileRule, MappingFile
from scalar.ingest.merged_scans import SCAN, report_merged
from scalar.ingest.overlapping_files import report_overlaps
from scalar.ingest.raw_table import RawTable
from scalar.ingest.row_profiles import points_of_rows

SAME_POSE = 1e-3
"""Most by which joint angles [rad] may differ between the rows of one pose: encoders dither by less, and poses differ by more."""


def read_block(
    mapping: MappingFile,
    block: Block,
    chosen: Sequence[tuple[Path, FileRule]],
    faults: list[Fault],
    left_out: list[LeftOut],
    rows_are_points: bool = False,
) -> tuple[ImportedTable | None, ImportedTable | None]:
    """Return the table of a block, from all its files, and the table of its points if its rows are points.

    Args:
        mapping: The mapping.
        block: The block, which says what the columns of the table are.
        chosen: The files to read, each with its rule, whose name is what messages call the file.
        faults: Every fault found is added here.
        left_out: Rows that ``drop_without`` leaves out are added here.
        rows_are_points: Whether every row is a point. The first table then has one row for each pose; the second has the coordinates
            of all points, and in the column ``_row`` the row of their pose in the first.

    Returns:
        Both tables; None for both if there are faults, and for the second if rows are not points.
    """
    files = _Files(mapping, block, faults, left_out, rows_are_points)
    known = len(faults)
    for path, rule in chosen:
        files.add(path, rule)
    faults[known:] = named_once(faults[known:])
    before = len(faults)
    report_copies(files.read, block, mapping.measured_in(block), faults)
    # Nests may be measured once, and written to every pose.
    if len(faults) == before and block is not mapping.nests:
        report_overlaps([one.rows for one in files.read], mapping.measured_in(block), faults)
    if faults or not files.parts:
        return None, None
    try:
        table, points = joined(files.parts), joined(files.points) if files.points else None
    except InvalidInput as error:
        faults += error.faults
        return None, None
    if mapping.table is not None and mapping.table.several_rows and block is mapping.points:
        report_merged(table, block, faults)
    table.columns.pop(SCAN, None)
    return table, points


@dataclass
class _Files:
    """The files of a block that were read so far, and what they give.

    Attributes:
        mapping, block, faults, left_out, rows_are_points: As for ``read_block``.
        parts: The table of each file, with one row for each pose.
        points: The coordinates of the points of each file, if rows are points.
        read: Each file as it was read, for the search for copies.
        faulty: ``{digest of a file that is at fault: its name}``.
        n_poses: Number of poses that were read.
        next_id: The number from which the poses of the next file are counted.
        next_scan: The number from which its scans are counted.
    """

    mapping: MappingFile
    block: Block
    faults: list[Fault]
    left_out: list[LeftOut]
    rows_are_points: bool
    parts: list[ImportedTable] = field(default_factory=list)
    points: list[ImportedTable] = field(default_factory=list)
    read: list[FileRead] = field(default_factory=list)
    faulty: dict[bytes, str] = field(default_factory=dict)
    n_poses: int = 0
    next_id: int = 0
    next_scan: int = 0

    def add(self, path: Path, rule: FileRule) -> None:
        """Read a file, and add what it gives; or add its faults to ``faults``."""
        n_before = len(self.faults)
        if self.faulty and (same := self.faulty.get(digest_of(path))) is not None:
            message = f"has the same bytes as {same}, which is at fault; leave one of them out"
            self.faults.append(Fault(rule.name, message))
            return
        try:
            raw, whole = _read_file(
                self.mapping, self.block, path, rule, self.faults, self.left_out, self.next_scan
            )
            self.next_scan += len(raw.lines) + 1
            keep, owner = _first_rows(raw, whole, self.block, self.faults)
        except InvalidInput as error:
            self.faults += error.faults
            if len(self.faults) > n_before:
                self.faulty.setdefault(digest_of(path), rule.name)
            return
        table = select_rows(whole, keep)
        self.next_id = _number_poses(table, rule, self.next_id)
        self.read.append(FileRead(rule, whole, table.columns["pose"]))
        if self.rows_are_points:
            coordinates = {name: whole.columns[name] for name in self.mapping.measured_columns}
            for name in coordinates:
                del table.columns[name]
            coordinates["_row"] = owner + float(self.n_poses)
            self.points.append(replace(whole, columns=coordinates, bad={}))
        self.n_poses += table.n_rows
        self.parts.append(table)


def _number_poses(table: ImportedTable, rule: FileRule, next_id: int) -> int:
    """Give the poses of a file their numbers in the dataset, counted if no column has them; return from which number the next file counts."""
    if "pose" not in table.columns:
        start = next_id if rule.first_pose is None else rule.first_pose
        table.columns["pose"] = np.arange(start, start + table.n_rows, dtype=float)
        next_id = start + table.n_rows
    table.columns["pose"] = table.columns["pose"] + rule.add_to_pose
    return next_id


def _read_file(
    mapping: MappingFile,
    block: Block,
    path: Path,
    rule: FileRule,
    faults: list[Fault],
    left_out: list[LeftOut],
    next_scan: int,
) -> tuple[RawTable, ImportedTable]:
    """Return one file as it is, and its columns in SI; a row of several targets has a row for each of them.

    Args:
        mapping: The mapping.
        block: The block of the file.
        path: The file.
        rule: What holds for all its rows; ``name`` is what messages call the file.
        faults: Every fault found is added here.
        left_out: Rows that ``drop_without`` leaves out are added here.
        next_scan: The number from which scans are counted in this file.

    Raises:
        InvalidInput: The file cannot be read, or there are faults.
    """
    raw = read_raw(path, {**mapping.text, **block.text}, mapping.variable, rule.name)
    raw = _rows_like(raw, block, left_out)
    if block.row_profiles is not None:
        raw = points_of_rows(raw, block.row_profiles)
    elif block.column_profiles is not None:
        raw = points_of_columns(raw, block.column_profiles)
    raw = replace(raw, rows_per_pose=block.rows_per_pose)
    tables = [
        read_columns(raw, one, replace(rule, text={**rule.text, **text}), faults, left_out, next_scan)
        for one, text in block.of_each_target()
    ]
    return raw, _in_order(tables)


def _rows_like(raw: RawTable, block: Block, left_out: list[LeftOut]) -> RawTable:
    """Return the rows of a file that ``rows_like`` keeps; the others are noted.

    Raises:
        InvalidInput: A column is missing, or no row is kept.
    """
    if not block.rows_like:
        return raw
    keep = raw.like(block.rows_like)
    wanted = " and ".join(f"{name} like '{pattern}'" for name, pattern in block.rows_like.items())
    if not keep.any():
        sets = any("[" in pattern for pattern in block.rows_like.values())
        hint = " ([ begins a set of signs, as in [0-9]; write [[] for this sign itself)" if sets else ""
        raise InvalidInput(Fault(raw.file, f"no row has {wanted}; correct rows_like in the mapping{hint}"))
    if not keep.all():
        rows = tuple(int(line) for line in raw.lines[~keep])
        left_out.append(LeftOut(raw.file, rows, f"which do not have {wanted} (rows_like)"))
    return raw.of_rows(keep)


def _in_order(tables: Sequence[ImportedTable]) -> ImportedTable:
    """Return the rows of several tables from one file in the order of the file, those of one row in the order of the tables."""
    if len(tables) == 1:
        return tables[0]
    of_columns = {name: dict.fromkeys(table.labels[name] for table in tables) for name in tables[0].labels}
    together = replace(
        joined(tables), labels={name: " or ".join(found) for name, found in of_columns.items()}
    )
    return select_rows(together, np.argsort(together.line_numbers(), kind="stable"))


def _first_rows(
    raw: RawTable, table: ImportedTable, block: Block, faults: list[Fault]
) -> tuple[Array, Array]:
    """Return the rows that are the first of their pose, and for every row the index of its pose in this file, ``(N,)``."""
    if block.first_of_each is None:
        rows = np.arange(table.n_rows)
        return rows, rows
    key = table.columns.pop("_pose")
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    keep = np.sort(first)
    owner = np.searchsorted(keep, first[inverse])
    lines = table.line_numbers()
    for name in (name for name in table.columns if JOINT.fullmatch(name)):
        values = table.columns[name]
        away = np.abs(values - values[keep][owner]) > SAME_POSE

        def message(i: int, name: str = name) -> str:
            first = f"row {lines[keep[owner[i]]]}, which has the same {raw.label(block.first_of_each or '')}"
            return f"{name} differs from that in {first}: these are two poses; correct first_of_each"

        table.report(faults, name, away, message)
    return keep, owner
