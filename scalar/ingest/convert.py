"""Import foreign tables as a dataset: ``scalar import``.

A mapping file says which column is which (`scalar.ingest.mapping`), the tables are read (`scalar.ingest.foreign_tables`),
and the result is checked as a dataset folder is before anything is written. Faults name the foreign file, its row and its column.
"""

import os
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset_writer import refuse_dataset, write_dataset
from scalar.data.formats import IMPORTED, NOT_STATED
from scalar.data.located_table import check_cells
from scalar.data.pose_numbers import report_shifted
from scalar.data.references import check_references, references_layout
from scalar.data.table_consistency import check_points, check_poses, points_layout, poses_layout
from scalar.data.unit_suspicions import suspect_joint_angles, suspect_points, write_si
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.converted_joints import converted_joints, formulas, unconverted_signs
from scalar.ingest.imported_table import ImportedTable, by_file
from scalar.ingest.left_out import LeftOut
from scalar.ingest.mapping import Block, FileRule, MappingFile
from scalar.ingest.mapping_reader import load_mapping
from scalar.ingest.matching import give_to_nearest, keep_matched
from scalar.ingest.named_units import unit_of_column
from scalar.ingest.read_block import read_block
from scalar.ingest.source_files import choose_files

_FILES_SHOWN = 3  # files of points of which each suspect column is reported; one more line counts the others


def import_dataset(
    mapping_path: str | os.PathLike[str],
    sources: Sequence[str | os.PathLike[str]],
    dataset_dir: str | os.PathLike[str],
    robot: Mapping[str, Any] | None = None,
    *,
    force: bool = False,
) -> tuple[list[LeftOut], list[str]]:
    """Write a dataset folder from foreign tables; it appears whole or not at all.

    Return which rows were left out, and sentences on joints whose angles or directions are not those of the controller, and on an order of
    acquisition that nothing states.

    Args:
        mapping_path: the mapping file.
        sources: files, or folders that hold the files that the mapping names.
        dataset_dir: the folder to write; a dataset there is replaced if SCALAR wrote it and nobody changed it since.
        robot: the ``robot:`` block of the dataset, if the mapping states none.
        force: whether a dataset there is replaced in any case.

    Raises:
        InvalidInput: mapping or tables are at fault; every fault that was found, by file, row and column.
    """
    refuse_dataset(dataset_dir, force)
    mapping = load_mapping(Path(mapping_path), robot)
    paths = [Path(source) for source in sources]
    chosen = choose_files(mapping, paths, Path(mapping_path).name)
    faults: list[Fault] = []
    left_out: list[LeftOut] = []
    several = mapping.several_points
    poses, points, nests = _read_blocks(mapping, chosen, faults, left_out)
    if faults or poses is None:
        # A column that is added to a second one is read twice.
        raise InvalidInput(list(dict.fromkeys(faults)))
    if points is not None:
        poses, points = _matched(mapping.points, poses, points, left_out)
    unstated = _number_in_order(mapping.poses, poses)
    if several and points is not None:
        ids = poses.columns["pose"][points.columns.pop("_row").astype(int)]
        points.columns = {"pose": ids, **points.columns}
    elif points is None and mapping.point_columns:
        names = ("pose", *mapping.measured_columns)
        points = replace(poses, columns={name: poses.columns[name] for name in names}, bad={})
    file = Path(mapping_path).name
    _check(mapping, poses, points, faults, file)
    if nests is not None and mapping.references is not None:
        check_cells(nests, references_layout(mapping.references), faults)
        check_references(nests, mapping.references, poses, faults)
        for part in by_file(nests):
            suspect_points(part, mapping.references, faults, _unit_advice(file, "nests", mapping.nests))
    if faults:
        raise InvalidInput(faults)
    _write(mapping, file, poses, points, nests, dataset_dir, force)
    return left_out, [
        sentence
        for sentence in (converted_joints(mapping, file), unconverted_signs(mapping), unstated)
        if sentence
    ]


def _matched(
    block: Block | None, poses: ImportedTable, points: ImportedTable, left_out: list[LeftOut]
) -> tuple[ImportedTable, ImportedTable]:
    """Return the poses, and the points with the numbers of their poses, as the block of the points says; rows left out are noted.

    Raises:
        InvalidInput: Points do not find their poses.
    """
    if block is None:
        return poses, points
    faults: list[Fault] = []
    if block.nearest_time is not None:
        points = give_to_nearest(points, poses, block.nearest_time, faults, left_out)
    elif block.matched_only:
        report_shifted(points, poses, faults)
    if block.matched_only and not faults:
        poses, points = keep_matched(poses, points, left_out)
    if faults:
        raise InvalidInput(faults)
    return poses, points


def _read_blocks(
    mapping: MappingFile,
    chosen: Sequence[Sequence[tuple[Path, FileRule]]],
    faults: list[Fault],
    left_out: list[LeftOut],
) -> tuple[ImportedTable | None, ImportedTable | None, ImportedTable | None]:
    """Return the tables of poses, points and nests from the files chosen for each; faults of one table do not hide those of another."""
    several = mapping.several_points
    poses, points = read_block(mapping, mapping.poses, chosen[0], faults, left_out, rows_are_points=several)
    nests, of_points, of_nests = None, list[Fault](), list[Fault]()
    if mapping.points is not None:
        points, _ = read_block(mapping, mapping.points, chosen[1], of_points, left_out)
    if mapping.nests is not None:
        nests, _ = read_block(mapping, mapping.nests, chosen[2], of_nests, left_out)
    faults += [*of_points, *of_nests]
    return poses, points, nests


def _number_in_order(block: Block, poses: ImportedTable) -> str | None:
    """Add the column ``order`` if something states the order of acquisition; else return a sentence that nothing does, and what to do.

    A table may have been sorted, or averaged over runs. Without the column, the rows of the dataset stand for the order, and ``imported`` in its
    dataset.yaml says that nobody stated it.
    """
    if "order" in poses.columns:
        return None
    if "time" in poses.columns or block.rows_in_order:
        poses.columns["order"] = _order(poses)
        return None
    return (
        "no column states when the poses were measured, so that no diagnosis will name anything that follows their order (a drift, a slip) with more "
        "than 50 %: if the rows are in the order of acquisition, write rows_in_order: true under poses in the mapping, or map a column time or order"
    )


def _order(poses: ImportedTable) -> Array:
    """Return the order of acquisition ``(N,)``: files as the mapping lists them, and in a file the rows by their time, if it is stated."""
    _, first, file = np.unique(poses.files.astype(str), return_index=True, return_inverse=True)
    time = poses.columns.get("time", np.zeros(poses.n_rows))
    return np.argsort(np.lexsort((time, first[file]))).astype(float)


def _unit_advice(file: str, key: str, block: Block | None) -> Callable[[str, str], str]:
    """Return the function that says what to change in a mapping where numbers of a column look like another unit."""

    def advice(si: str, column: str) -> str:
        if block is None or column not in block.columns:
            return write_si(si)
        return unit_of_column(block.columns[column].unit, f"{key}.columns.{column}", file, si)

    return advice


def _check(
    mapping: MappingFile,
    poses: ImportedTable,
    points: ImportedTable | None,
    faults: list[Fault],
    file: str,
) -> None:
    """Add the faults that a dataset folder with these tables would have; ``file`` is the name of the mapping file."""
    description, layout = mapping.description, mapping.table
    of_poses = _unit_advice(file, "poses", mapping.poses)
    of_points = of_poses if mapping.points is None else _unit_advice(file, "points", mapping.points)
    check_cells(poses, poses_layout(description), faults)
    check_poses(poses, description, faults)
    found: list[Fault] = []
    for part in by_file(poses):
        suspect_joint_angles(part, description, found, of_poses)
    faults += _as_labelled(found, poses)
    if points is not None and layout is not None:
        check_cells(points, points_layout(layout, description), faults)
        if points.good("pose"):  # else its faults were reported with the poses
            check_points(points, poses, layout, faults)
            found = []
            for part in by_file(points):
                suspect_points(part, layout, found, of_points)
            faults += _as_labelled(_of_first_files(found), points)


def _of_first_files(found: Sequence[Fault]) -> list[Fault]:
    """Return the faults of the first few files of each column, and one that counts the further files: a scanner may write one for each pose."""
    kept, more = list[Fault](), Counter[str]()
    files: dict[str, set[str]] = defaultdict(set)
    for fault in found:
        column = fault.column or ""
        known = files[column]
        if fault.file in known or len(known) < _FILES_SHOWN:
            known.add(fault.file)
            kept.append(fault)
        else:
            more[column] += 1
    for column, count in more.items():
        last = next(fault for fault in reversed(kept) if (fault.column or "") == column)
        message = f"{count} more faults of this kind in other files; look for a common cause"
        kept.append(Fault(last.file, message, column=last.column))
    return kept


def _as_labelled(found: list[Fault], table: ImportedTable) -> list[Fault]:
    """Return faults whose columns have the names that they have in the files."""
    return [replace(fault, column=table.labels.get(fault.column or "", fault.column)) for fault in found]


def _write(
    mapping: MappingFile,
    file: str,
    poses: ImportedTable,
    points: ImportedTable | None,
    nests: ImportedTable | None,
    dataset_dir: str | os.PathLike[str],
    force: bool,
) -> None:
    """Write the dataset folder.

    Args:
        mapping: The mapping.
        file: Name of the mapping's file, which the description of the dataset records.
        poses: The table of poses.
        points: The table of what the sensor measured, or None.
        nests: The table of the points fixed to the base, or None.
        dataset_dir: The folder.
        force: Whether a dataset that is there is replaced.

    Raises:
        InvalidInput: The folder cannot be written.
    """
    n = mapping.description.n_joints
    joints = [f"q{i + 1}" for i in range(n)]
    approach = [f"approach{i + 1}" for i in range(n)]
    first = ["pose", "plane", *joints, "order", "time", "temperature", "session", *approach]
    rest = [name for name in poses.columns if name not in (*first, *mapping.measured_columns)]
    frame = _frame(poses, [name for name in (*first, *rest) if name in poses.columns], joints)
    measured = {}
    if points is not None and mapping.table is not None:
        names = ["pose", *mapping.measured_columns]
        measured[mapping.table.stem] = _frame(points, names, mapping.measured_columns)
    if nests is not None and mapping.references is not None and mapping.nests is not None:
        table = mapping.references
        names = [
            name
            for name in ("pose", *table.further[:1], *table.units, *table.optional)
            if name in nests.columns
        ]
        measured[table.stem] = _frame(nests, names, (*table.units, *table.optional))
    content = dict(mapping.description.mapping)
    content.pop(IMPORTED, None)
    record = {}
    if converted := formulas(mapping):
        record["joints"] = ", ".join(converted)
    if not {"order", "time"} & {*frame.columns}:
        record["order"] = NOT_STATED
    if record:
        content[IMPORTED] = {"mapping": file} | record
    write_dataset(dataset_dir, mapping=content, poses=frame, force=force, **measured)


def _frame(table: ImportedTable, names: Sequence[str], always_float: Collection[str]) -> pd.DataFrame:
    """Return the table to write; columns of whole numbers become integers, except those in `always_float`."""
    frame = pd.DataFrame({name: table.columns[name] for name in names})
    for name in names:
        values = table.columns[name]
        whole = values.dtype != object and name not in always_float
        if whole and np.all(values == np.round(values)) and np.all(np.abs(values) < 2.0**53):
            frame[name] = values.astype(np.int64)
    return frame
