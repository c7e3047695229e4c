"""Write the table of ``scalar correct``: joint angles to command, and how each row was corrected."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.cli.correct_words import is_near_singular
from scalar.cli.corrected_targets import CorrectedTargets
from scalar.data.io.atomic import atomic_write
from scalar.data.io.semicolons import cells_as_written
from scalar.data.table_units import TableUnits
from scalar.estimation.frame_tables import ORIENTATIONS, is_frame_column
from scalar.geometry.se3 import Array


def write_corrected(path: Path, corrected: CorrectedTargets, leave_out: bool) -> int:
    """Write the joint angles to command, the other columns of the targets, and the columns that say how each row was corrected.

    Args:
        path: CSV file to write.
        corrected: The corrected targets.
        leave_out: Whether rows without joint angles are left out; if not, these cells of theirs are empty.

    Returns:
        The number of rows that were written.
    """
    targets = corrected.targets
    table = targets.table.iloc[corrected.rows] if leave_out else targets.table
    rows = np.searchsorted(table.index.to_numpy(), corrected.rows)
    joints = {name: _in_rows(rows, len(table), column) for name, column in _joints(corrected).items()}
    how = {
        name: _in_rows(rows, len(table), column, 0 if name == "corrected" else "")
        for name, column in _how_corrected(corrected).items()
    }
    others = _other_columns(targets.path, table, {"pose", *_joint_names(corrected), *how})
    columns = {"pose": table["pose"].to_numpy()} | joints | others | how
    with atomic_write(path) as temporary:
        targets.text_form.write(pd.DataFrame(columns), temporary, "%.15g")
    return len(table)


def _in_rows(rows: Array, n: int, values: Array, empty: object = "") -> Array:
    """Return a column ``(n,)`` with values ``(M,)`` in the given rows ``(M,)`` and ``empty`` in the others."""
    if len(rows) == n:
        return values
    column = np.full(n, empty, dtype=object)
    column[rows] = values
    return column


def _joints(corrected: CorrectedTargets) -> dict[str, Array]:
    """Return the columns of the joint angles ``(M,)`` of the M rows that have such, as the controller counts them if its convention is known."""
    units, q = corrected.targets.units, corrected.found.q
    if (convention := corrected.targets.convention) is not None:
        q = convention.to_controller(q)
    return {units.named(name): q[:, i] / units.of(name)[1] for i, name in enumerate(_joint_names(corrected))}


def _joint_names(corrected: CorrectedTargets) -> list[str]:
    """Return the names ``q1 .. qn`` of the columns of joint angles, without units."""
    return [f"q{i + 1}" for i in range(corrected.found.q.shape[1])]


def _how_corrected(corrected: CorrectedTargets) -> dict[str, Array]:
    """Return the columns ``(M,)`` that say how each of the M rows that have joint angles was corrected."""
    units = corrected.targets.units
    found, near = corrected.found, corrected.sensitivity
    return {
        "corrected": found.reached.astype(int),
        "beyond_limits": found.beyond_limits.sum(axis=1),
        "near_singular": is_near_singular(near).astype(int),
        "smallest_singular_value": near.singular_value,
        _with_unit("position_error", units, "x"): found.position_error / units.of("x")[1],
        _with_unit("orientation_error", units, "rx"): found.orientation_error / units.of("rx")[1],
    }


def _with_unit(name: str, units: TableUnits, like: str) -> str:
    """Return the name of a column that has the unit of the column ``like``."""
    return f"{name}{units.named(like).removeprefix(like)}"


def _other_columns(path: Path, table: pd.DataFrame, written: Collection[str]) -> dict[str, Any]:
    """Return the columns of the targets that are copied: all but the frames and those that are written anew.

    Args:
        path: File of the targets, whose cells are copied as they are written there.
        table: The rows to copy; its index counts the rows of the file.
        written: Names of the columns that are written anew, without units.
    """
    of_frames = {c for form in ORIENTATIONS.values() for c in form} if "x" in table.columns else set()
    cells = cells_as_written(path)
    columns: dict[str, Any] = {}
    for name in map(str, table.columns):
        if name not in written and name not in of_frames and not is_frame_column(name):
            columns[name] = [cells[name][i] for i in table.index] if name in cells else table[name].to_numpy()
    return columns
