"""Import foreign tables into a dataset of our format: ``scalar import``.

A mapping file says which column is which (`scalar.ingest.mapping`), the tables are read as they stand
(`scalar.ingest.foreign_tables`), and what comes of them passes the checks of a dataset folder before anything is
written. Faults name the foreign file, its row and its column. Left out: the orientation that some
trackers give, which the format has no place for.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pandas as pd

from scalar.data.dataset import write_dataset
from scalar.data.located_table import Layout, Table, check_cells
from scalar.data.table_consistency import check_points, check_poses, poses_layout
from scalar.data.unit_suspicions import suspect_joint_angles, suspect_points
from scalar.errors import Fault, InvalidInput
from scalar.ingest.foreign_tables import RawTable, read_raw
from scalar.ingest.mapping import JOINT, Block, FileRule, MappingFile, load_mapping

SAME_POSE = 1e-3
"""Joint angles [rad] may differ by this within the rows of one pose: encoders that dither, no two poses."""
_TEXT = ("plane", "session")
_EMPTY = "an empty cell; complete it, or let the mapping leave such rows out with drop_without"
_UNLIKE = "in all files or in none; name it for each, or for none"


@dataclass
class ImportedTable(Table):
    """A table of ours whose rows come from foreign files, in which its faults are named.

    Attributes:
        files: ``(N,)`` the name of the file that each row comes from.
        labels: by our column, what the files call it.
    """

    files: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=object))
    labels: dict[str, str] = field(default_factory=dict)

    def report(
        self, faults: list[Fault], column: str, mask: np.ndarray, message: Callable[[int], str]
    ) -> None:
        """Add a fault for every row of `mask`, in the words of the file it comes from."""
        found: list[Fault] = []
        super().report(found, column, mask, message)
        rows = iter(np.flatnonzero(mask))
        for fault in found:
            file = self.files[next(rows)] if fault.row is not None else self.file
            faults.append(replace(fault, file=file, column=self.labels.get(column, column)))


def import_dataset(
    mapping_path: str | os.PathLike[str],
    sources: Sequence[str | os.PathLike[str]],
    dataset_dir: str | os.PathLike[str],
) -> None:
    """Write a dataset folder from foreign tables; it appears whole or not at all.

    Args:
        mapping_path: the mapping file.
        sources: files, or folders that hold the files that the mapping names.
        dataset_dir: the folder to write; replaced if it is a dataset already.

    Raises:
        InvalidInput: mapping or tables are at fault; every fault that was found, by file, row and column.
    """
    mapping = load_mapping(Path(mapping_path))
    paths = [Path(source) for source in sources]
    chosen = _choose(mapping, paths, Path(mapping_path).name)
    faults: list[Fault] = []
    several = mapping.description.kind == "line-laser" and mapping.points is None
    poses, points = _read_block(mapping, mapping.poses, chosen[0], faults, spread=several)
    if mapping.points is not None:
        points, _ = _read_block(mapping, mapping.points, chosen[1], faults)
    if faults or poses is None:
        raise InvalidInput(faults)
    if "order" not in poses.columns:
        poses.columns["order"] = np.arange(poses.n_rows, dtype=float)
    if several and points is not None:
        ids = poses.columns["pose"][points.columns.pop("_row").astype(int)]
        points.columns = {"pose": ids, **points.columns}
    elif points is None and mapping.point_columns:
        names = ("pose", *mapping.point_columns)
        points = replace(poses, columns={name: poses.columns[name] for name in names}, bad={})
    _check(mapping, poses, points, faults)
    if faults:
        raise InvalidInput(faults)
    _write(mapping, poses, points, dataset_dir)


def _choose(
    mapping: MappingFile, sources: Sequence[Path], file: str
) -> tuple[list[tuple[Path, FileRule]], list[tuple[Path, FileRule]]]:
    """Return the files of the poses and of the points, each with its rule, in the order of the mapping."""
    blocks = [mapping.poses] + ([mapping.points] if mapping.points else [])
    rules = [rule for block in blocks for rule in block.files]
    faults, given = [], []
    for source in sources:
        if not source.is_dir():
            given.append(source)
        elif not rules:
            message = f"a folder, and {file} names no files; give the files themselves, or add poses.files"
            faults.append(Fault(str(source), message))
        else:
            names = sorted(path for path in source.iterdir() if path.is_file())
            given += [path for path in names if any(fnmatchcase(path.name, rule.name) for rule in rules)]
    if not rules:
        if faults:
            raise InvalidInput(faults)
        return [(path, FileRule(path.name, {}, {})) for path in given], []
    chosen: list[list[tuple[Path, FileRule]]] = [[], []]
    used: set[Path] = set()
    for block, found in zip(blocks, chosen, strict=False):
        taken: set[Path] = set()
        for rule in block.files:
            matching = [path for path in given if fnmatchcase(path.name, rule.name) and path not in taken]
            if not matching:
                message = f"{file} names this file, and it is not among the sources; give it, or its folder"
                faults.append(Fault(rule.name, message))
            found += [(path, rule) for path in matching]
            taken.update(matching)
        used |= taken
    for path in given:
        if path not in used:
            names = ", ".join(rule.name for rule in rules)
            message = f"{file} has no such file, only {names}; add it to files, or leave it out"
            faults.append(Fault(str(path), message))
    if faults:
        raise InvalidInput(faults)
    return chosen[0], chosen[1]


def _read_block(
    mapping: MappingFile,
    block: Block,
    chosen: Sequence[tuple[Path, FileRule]],
    faults: list[Fault],
    spread: bool = False,
) -> tuple[ImportedTable | None, ImportedTable | None]:
    """Return a block's table over its files, and with `spread` the coordinates of all rows, with ``_row``."""
    parts: list[ImportedTable] = []
    spreads: list[ImportedTable] = []
    n_poses, next_id = 0, 0
    for path, rule in chosen:
        try:
            raw = read_raw(path, mapping.text, mapping.variable)
            whole = _read_columns(raw, block, rule, faults)
            keep, owner = _first_rows(raw, whole, block, faults)
        except InvalidInput as error:
            faults += error.faults
            continue
        table = _rows(whole, keep)
        if "pose" not in table.columns:
            start = next_id if rule.first_pose is None else rule.first_pose
            table.columns["pose"] = np.arange(start, start + table.n_rows, dtype=float)
            next_id = start + table.n_rows
        if spread:
            coordinates = {name: whole.columns[name] for name in mapping.point_columns}
            for name in coordinates:
                del table.columns[name]
            coordinates["_row"] = owner + float(n_poses)
            spreads.append(replace(whole, columns=coordinates, bad={}))
        n_poses += table.n_rows
        parts.append(table)
    if faults or not parts:
        return None, None
    return _joined(parts), _joined(spreads) if spreads else None


def _read_columns(raw: RawTable, block: Block, rule: FileRule, faults: list[Fault]) -> ImportedTable:
    """Return the columns of one file in SI, rows without a measurement left out."""
    columns: dict[str, np.ndarray] = {}
    empty: dict[str, np.ndarray] = {}
    for name, column in block.columns.items():
        try:
            if name in _TEXT:
                text, empty[name] = raw.text(column.reference)
                names = column.names or {}
                columns[name] = np.array([names.get(cell, cell) for cell in text], dtype=object)
            else:
                values, empty[name] = raw.numbers(column.reference, faults)
                columns[name] = column.to_si(column.sign * values + column.offset)
        except InvalidInput as error:
            faults += error.faults
    if faults:
        raise InvalidInput(())
    n = len(raw.lines)
    for name, text in rule.text.items():
        columns[name] = np.full(n, text, dtype=object)
    for name, value in rule.covariates.items():
        columns[name] = np.full(n, value)
    keep = np.ones(n, dtype=bool)
    for name in block.drop_without:
        keep &= ~empty[name]
    if not keep.any():
        wanted = " and ".join(block.drop_without)
        message = f"no row has {wanted}, so that none is left; check columns and drop_without"
        raise InvalidInput(Fault(raw.file, message))
    labels = {name: raw.label(column.reference) for name, column in block.columns.items()}
    lines, files = raw.lines, np.full(n, raw.file, dtype=object)
    table = ImportedTable(raw.file, columns, lambda: lines, files=files, labels=labels)
    for name, missing in empty.items():
        table.report(faults, name, missing & keep, lambda _: _EMPTY)
    if block.first_of_each is not None:
        key = raw.text(block.first_of_each)[0].astype(str)
        columns["_pose"] = np.unique(key, return_inverse=True)[1].astype(float)
    return _rows(table, np.flatnonzero(keep))


def _first_rows(
    raw: RawTable, table: ImportedTable, block: Block, faults: list[Fault]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows that are poses, and for every row its pose ``(N,)``, counted in this file."""
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


def _rows(table: ImportedTable, keep: np.ndarray) -> ImportedTable:
    """Return some rows of a table."""
    lines = table.line_numbers()[keep]
    columns = {name: values[keep] for name, values in table.columns.items()}
    return replace(table, columns=columns, line_numbers=lambda: lines, files=table.files[keep], bad={})


def _joined(tables: Sequence[ImportedTable]) -> ImportedTable:
    """Return tables below one another; all have the same columns."""
    lines = np.concatenate([table.line_numbers() for table in tables])
    first = tables[0]
    faults = [
        Fault(table.file, f"{name} is known of this file or of {first.file} only, and has to be {_UNLIKE}")
        for table in tables
        for name in sorted(table.columns.keys() ^ first.columns.keys())
    ]
    if faults:
        raise InvalidInput(faults)
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in first.columns}
    files = np.concatenate([table.files for table in tables])
    return replace(first, columns=columns, line_numbers=lambda: lines, files=files, bad={})


def _check(
    mapping: MappingFile, poses: ImportedTable, points: ImportedTable | None, faults: list[Fault]
) -> None:
    """Add what the checks of a dataset folder find in the tables that would be written."""
    description, kind = mapping.description, mapping.description.kind
    check_cells(poses, poses_layout(description), faults)
    check_poses(poses, description, faults)
    for part in _by_file(poses):
        found: list[Fault] = []
        suspect_joint_angles(part, description, found)
        faults += [
            replace(fault, column=poses.labels.get(fault.column or "", fault.column)) for fault in found
        ]
    if points is not None and kind is not None:
        check_cells(points, Layout(("pose", *mapping.point_columns)), faults)
        own = [] if points.good("pose") else ["pose"]  # reported with the poses already
        if not own:
            check_points(points, poses, kind, faults)
            for part in _by_file(points):
                suspect_points(part, kind, faults)


def _by_file(table: ImportedTable) -> list[ImportedTable]:
    """Return the rows of each file as a table of that file's name."""
    names = dict.fromkeys(table.files)
    return [replace(_rows(table, np.flatnonzero(table.files == name)), file=name) for name in names]


def _write(
    mapping: MappingFile,
    poses: ImportedTable,
    points: ImportedTable | None,
    dataset_dir: str | os.PathLike[str],
) -> None:
    n = mapping.description.n_joints
    joints = [f"q{i + 1}" for i in range(n)]
    approach = [f"approach{i + 1}" for i in range(n)]
    first = ["pose", "plane", *joints, "order", "time", "temperature", "session", *approach]
    rest = [name for name in poses.columns if name not in (*first, *mapping.point_columns)]
    frame = _frame(poses, [name for name in (*first, *rest) if name in poses.columns])
    table = None if points is None else _frame(points, ["pose", *mapping.point_columns])
    scans, points_ = (table, None) if mapping.description.kind == "line-laser" else (None, table)
    content = mapping.description.mapping
    write_dataset(dataset_dir, mapping=content, poses=frame, scans=scans, points=points_)


def _frame(table: ImportedTable, names: Sequence[str]) -> pd.DataFrame:
    """Return columns as they are written: text, numbers, and integers where all are."""
    frame = pd.DataFrame({name: table.columns[name] for name in names})
    for name in names:
        values = table.columns[name]
        whole = values.dtype != object and not JOINT.fullmatch(name) and name not in ("x", "y", "z")
        if whole and np.all(values == np.round(values)) and np.all(np.abs(values) < 2.0**53):
            frame[name] = values.astype(np.int64)
    return frame
