"""A table of Denavit-Hartenberg parameters as the ``robot:`` block of a dataset: a row a joint, units in the names of the columns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scalar.data.io.csv_reader import read_csv
from scalar.data.located_table import Layout
from scalar.errors import Fault, InvalidInput
from scalar.units import DEG, MM

CONVENTIONS = ("modified-dh", "standard-dh")
_LENGTHS = {"m": 1.0, "mm": MM}
_ANGLES = {"rad": 1.0, "deg": DEG}
_PARAMETERS = {"a": _LENGTHS, "alpha": _ANGLES, "d": _LENGTHS, "theta": _ANGLES}
_LIMITS = ("lower", "upper")


def robot_from_dh_table(path: Path, convention: str, name: str) -> dict[str, Any]:
    """Return the ``robot:`` block that a table describes.

    Args:
        path: CSV file with a row for each joint, base to flange. Columns: ``a_mm`` or ``a_m``, ``alpha_deg`` or ``alpha_rad``, and so
            on for d and theta; optional ``lower_deg`` and ``upper_deg`` (or ``_rad``), the limits of the joint.
        convention: One of ``CONVENTIONS``.
        name: Of the robot.

    Raises:
        InvalidInput: With every fault of the table; a column may be missing, be there in two units, or have an unknown name.
    """
    columns = {f"{key}_{unit}" for key, units in _PARAMETERS.items() for unit in units}
    columns |= {f"{key}_{unit}" for key in _LIMITS for unit in _ANGLES}
    faults: list[Fault] = []
    table = read_csv(path, Layout((), tuple(sorted(columns)), integers=frozenset()), faults)
    if table is None or faults:
        raise InvalidInput(faults)
    values = {
        key: _column(path, table.columns, key, units, key in _PARAMETERS, faults)
        for key, units in (_PARAMETERS | dict.fromkeys(_LIMITS, _ANGLES)).items()
    }
    if (values["lower"] is None) != (values["upper"] is None):
        faults.append(
            Fault(path.name, "a lowest angle without a highest, or the other way round; give both, or none")
        )
    if not table.n_rows:
        faults.append(Fault(path.name, "no rows; write a row for each joint, base to flange"))
    if faults:
        raise InvalidInput(faults)
    joints = []
    for i in range(table.n_rows):
        joint: dict[str, Any] = {key: column[i] for key in _PARAMETERS if (column := values[key]) is not None}
        if values["lower"] is not None and values["upper"] is not None:
            joint["limits"] = [values["lower"][i], values["upper"][i]]
            if not joint["limits"][0] < joint["limits"][1]:
                message = "the lowest angle is not below the highest; swap them"
                faults.append(Fault(path.name, message, int(table.line_numbers()[i])))
        joints.append(joint)
    if faults:
        raise InvalidInput(faults)
    return {"name": name, "convention": convention, "joints": joints}


def _column(
    path: Path,
    columns: dict[str, Any],
    key: str,
    units: dict[str, float],
    required: bool,
    faults: list[Fault],
) -> list[float] | None:
    """Return the numbers of a column in metres or radians, None if it is not there."""
    there = [unit for unit in units if f"{key}_{unit}" in columns]
    choice = " or ".join(f"{key}_{unit}" for unit in units)
    if len(there) == 1:
        return [float(value) * units[there[0]] for value in columns[f"{key}_{there[0]}"]]
    if there:
        faults.append(Fault(path.name, f"there twice, in two units; keep {choice}", 1, key))
    elif required:
        faults.append(Fault(path.name, f"the column is missing; write {choice}", 1, key))
    return None
