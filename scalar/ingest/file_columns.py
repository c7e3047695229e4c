"""Read the columns of one foreign file that a block of a mapping names, in SI, without the rows that the mapping leaves out."""

import numpy as np

from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.directions import read_directions
from scalar.ingest.imported_table import MEASURED_AT, ImportedTable, select_rows
from scalar.ingest.left_out import LeftOut
from scalar.ingest.mapping import APPROACH, TEXT_COLUMNS, Block, Column, FileRule
from scalar.ingest.merged_scans import SCAN, number_scans
from scalar.ingest.orientation import to_rotation_vectors
from scalar.ingest.raw_table import RawTable

_EMPTY = "an empty cell; complete it, or let the mapping leave such rows out with drop_without"
_WITHOUT_TIME = (
    "an empty cell; complete it, or let the mapping leave such rows out by rows_like: {this column: '?*'}"
)


def read_columns(
    raw: RawTable,
    block: Block,
    rule: FileRule,
    faults: list[Fault],
    left_out: list[LeftOut],
    first_scan: int,
) -> ImportedTable:
    """Return the columns of one file in SI, without the rows that ``drop_without`` and ``drop_zeros`` leave out; these are noted.

    Args:
        raw: The file.
        block: The block of the mapping, of one target.
        rule: What holds for all rows of the file.
        faults: Every fault found is added here.
        left_out: Rows that are left out are added here.
        first_scan: The number from which scans are counted in this file.
    """
    columns, empty, midnight = _columns(raw, block, faults)
    if faults:
        raise InvalidInput(())
    n = len(raw.lines)
    columns |= {name: np.full(n, text, dtype=object) for name, text in rule.text.items()}
    columns |= {name: np.full(n, value) for name, value in rule.covariates.items()}
    scans = number_scans(raw, block, first_scan)
    if scans is not None:
        columns[SCAN] = scans
    labels = {name: raw.label(column.reference) for name, column in block.columns.items()}
    if block.nearest_time is not None:
        labels[MEASURED_AT] = raw.label(block.nearest_time.column)
    lines, files = raw.lines, np.full(n, raw.file, dtype=object)
    table = ImportedTable(raw.file, columns, lambda: lines, files=files, labels=labels, midnight=midnight)
    keep = _kept(table, empty, block, left_out)
    for name, missing in empty.items():
        remedy = _WITHOUT_TIME if name == MEASURED_AT else _EMPTY
        table.report(faults, name, missing & keep, lambda _, remedy=remedy: remedy)
    if block.first_of_each is not None:
        key = raw.text(block.first_of_each)[0].astype(str)
        columns["_pose"] = np.unique(key, return_inverse=True)[1].astype(float)
    kept = select_rows(table, np.flatnonzero(keep))
    to_rotation_vectors(kept, block.euler_axes, faults)
    return kept


def _columns(
    raw: RawTable, block: Block, faults: list[Fault]
) -> tuple[dict[str, Array], dict[str, Array], float | None]:
    """Return the columns of a file by their names in the dataset, in which rows each is empty, and the midnight after which its times count."""
    columns: dict[str, Array] = {}
    empty: dict[str, Array] = {}
    midnight: float | None = None
    for name, column in block.columns.items():
        try:
            if name == "time":
                values, empty[name], midnight = raw.seconds(column.reference, faults)
                columns[name] = column.to_si(values)
            else:
                columns[name], empty[name] = _column(raw, name, column, faults)
        except InvalidInput as error:
            faults += error.faults
    if block.nearest_time is not None:
        try:
            columns[MEASURED_AT], empty[MEASURED_AT], midnight = raw.seconds(
                block.nearest_time.column, faults
            )
        except InvalidInput as error:
            faults += error.faults
    return columns, empty, midnight


def _column(raw: RawTable, name: str, column: Column, faults: list[Fault]) -> tuple[Array, Array]:
    """Return a column of the dataset, ``(N,)``, and in which rows the file has nothing for it, ``(N,)`` bool."""
    if name in TEXT_COLUMNS:
        text, empty = raw.text(column.reference)
        names = column.names or {}
        return np.array([names.get(cell, cell) for cell in text], dtype=object), empty
    if APPROACH.fullmatch(name):
        values, empty = read_directions(raw, name, column.reference, column.values, faults)
    else:
        read = raw.pose_numbers if name == "pose" else raw.numbers
        values, empty = read(column.reference, faults)
        if column.second is not None:
            reference, sign = column.second
            added, none_added = read(reference, faults)
            values, empty = values + sign * added, empty | none_added
    return column.to_si(column.sign * values + column.offset), empty


def _kept(table: ImportedTable, empty: dict[str, Array], block: Block, left_out: list[LeftOut]) -> Array:
    """Return which rows ``(N,)`` of a file the keys ``drop_without`` and ``drop_zeros`` leave in; the others are noted.

    Raises:
        InvalidInput: No row is left.
    """
    columns, n = table.columns, table.n_rows
    keep = np.ones(n, dtype=bool)
    for name in block.drop_without:
        keep &= ~empty[name]
    zero = np.zeros(n, dtype=bool)
    if block.drop_zeros:
        zeros = {name: block.columns[name].to_si(block.columns[name].offset) for name in block.drop_zeros}
        zero = keep & np.all([columns[name] == zero for name, zero in zeros.items()], axis=0)
    if not (keep & ~zero).any():
        message = f"no row has {' and '.join(block.drop_without)}, so that none is left; check columns and drop_without"
        if zero.any():
            others = " that is not empty" if block.drop_without else ""
            message = f"{', '.join(block.drop_zeros)} are 0 in every row{others}, so that none is left; check columns and drop_zeros"
        raise InvalidInput(Fault(table.file, message))
    lines = table.line_numbers()
    if not keep.all():
        without = " or ".join(table.labels[name] for name in block.drop_without)
        left_out.append(LeftOut(table.file, _numbers(lines[~keep]), f"without {without} (drop_without)"))
    if zero.any():
        where = ", ".join(table.labels[name] for name in block.drop_zeros)
        left_out.append(LeftOut(table.file, _numbers(lines[zero]), f"with 0 in {where} (drop_zeros)"))
    return keep & ~zero


def _numbers(lines: Array) -> tuple[int, ...]:
    return tuple(int(line) for line in lines)
