"""A table of Denavit-Hartenberg parameters as the ``robot:`` block of a dataset: one row for each joint, units in the names of the columns."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scalar.data.io.csv_reader import read_csv
from scalar.data.located_table import NUMBER, Layout, Table, shorten
from scalar.data.unit_suspicions import MAX_CHAIN, MIN_CHAIN
from scalar.errors import Fault, InvalidInput
from scalar.units import DEG, MM

CONVENTIONS = ("modified-dh", "standard-dh")
_LENGTHS = {"m": 1.0, "mm": MM}
_ANGLES = {"rad": 1.0, "deg": DEG}
_PARAMETERS = {"a": _LENGTHS, "alpha": _ANGLES, "d": _LENGTHS, "theta": _ANGLES}
_LIMITS = ("lower", "upper")
_OTHER_LIMITS = {
    "min": "lower",
    "low": "lower",
    "qmin": "lower",
    "max": "upper",
    "high": "upper",
    "qmax": "upper",
}
_QUARTERS = 4  # a twist is a turn at most
_ROUNDED = 6e-3  # of a number such as 1.57 or 3.14 in the column
_SHOWN = 8  # joints that a message lists
_TYPE, _JOINT = "type", "joint"
_TYPES = ("revolute", "prismatic")


def robot_from_dh_table(path: Path, convention: str, name: str) -> dict[str, Any]:
    """Return the ``robot:`` block that a table describes.

    Args:
        path: CSV file with a row for each joint, base to flange. Columns: ``a_mm`` or ``a_m``, ``alpha_deg`` or ``alpha_rad``, and so
            on for d and theta; optional ``lower_deg`` and ``upper_deg`` (or ``_rad``), the limits of the joint, for prismatic
            joints ``lower_mm`` and ``upper_mm`` (or ``_m``), empty for a joint that has no such limits; optional ``type``, ``revolute``
            or ``prismatic``, and ``joint``: 1, 2, ..., or names such as J1.
        convention: One of ``CONVENTIONS``.
        name: Name of the robot.

    Raises:
        InvalidInput: With every fault of the table: columns that are missing, given in two units or unknown, and values that cannot be.
    """
    columns = {f"{key}_{unit}" for key, units in _PARAMETERS.items() for unit in units}
    columns |= {f"{key}_{unit}" for key in _LIMITS for unit in _ANGLES | _LENGTHS}
    faults: list[Fault] = []
    known = (*sorted(columns), _TYPE, _JOINT)
    limits_columns = frozenset(column for column in columns if column.startswith(_LIMITS))
    elsewhere = {
        f"{other}_{unit}": f"{key}_{unit}"
        for other, key in _OTHER_LIMITS.items()
        for unit in _ANGLES | _LENGTHS
    }
    elsewhere |= {key: " or ".join(f"{key}_{unit}" for unit in units) for key, units in _PARAMETERS.items()}
    layout = Layout(
        (),
        known,
        text=frozenset({_TYPE, _JOINT}),
        blank=limits_columns,
        semicolons=True,
        other_names=elsewhere,
    )
    table = read_csv(path, layout, faults)
    if table is None or faults:
        raise InvalidInput(faults)
    if not _in_order([str(name) for name in table.columns.get(_JOINT, ())]):
        names = ", ".join(str(name) for name in table.columns[_JOINT][:_SHOWN])
        message = (
            f"the rows are not joints 1, 2, ... in this order, but {names}; write them base to flange; where the maker leaves out a number (as in "
            "J1, J2, J3, J5, J6 of some arms with five axes), leave the column out"
        )
        faults.append(Fault(path.name, message, None, _JOINT))
    types = _types(path, table, faults)
    values = {
        key: _column(path, table.columns, key, units, True, faults) for key, units in _PARAMETERS.items()
    }
    limits = _limits(path, table, types, faults)
    if "prismatic" not in types:
        _check_reach(path, table, values, faults)
    if not table.n_rows:
        faults.append(Fault(path.name, "no rows; write a row for each joint, base to flange"))
    if faults:
        raise InvalidInput(faults)
    joints = []
    for i in range(table.n_rows):
        joint: dict[str, Any] = {key: column[i] for key in _PARAMETERS if (column := values[key]) is not None}
        if types[i] == "prismatic":
            joint["type"] = "prismatic"
        if limits[i] is not None:
            joint["limits"] = limits[i]
        joints.append(joint)
    return {"name": name, "convention": convention, "joints": joints}


def suspected_radians(robot: Mapping[str, Any]) -> str | None:
    """Return a line if all twists of an arm are, in degrees, such numbers as right angles are in radians; None if not.

    Args:
        robot: The ``robot:`` block, in SI.
    """
    degrees = [abs(float(joint["alpha"])) / DEG for joint in robot["joints"] if joint["alpha"]]
    quarter = math.pi / 2.0
    turns = [alpha / quarter for alpha in degrees]
    if not turns or not all(
        1 <= round(x) <= _QUARTERS and abs(x - round(x)) * quarter < _ROUNDED for x in turns
    ):
        return None
    return (
        f"Check the units: the twists alpha that are not zero are {max(degrees):.4g} degrees at most, and in radians they would be right angles. "
        "If the table has radians, call the column alpha_rad (theta likewise)."
    )


def _in_order(joints: Sequence[str]) -> bool:
    """Return whether the names of joints do not contradict the order of the rows.

    Numbers have to be 1, 2, ...; those of names such as J1 have to increase by one if the names agree otherwise. Words say nothing of an order.
    """
    if all(NUMBER.fullmatch(name) for name in joints):
        return [float(name) for name in joints] == list(range(1, len(joints) + 1))
    found = [re.fullmatch(r"(.*?)(\d+)", name) for name in joints]
    numbered = [match for match in found if match]
    if len(numbered) < len(joints) or len({match[1] for match in numbered}) > 1:
        return True
    numbers = [int(match[2]) for match in numbered]
    return numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def _check_reach(
    path: Path, table: Table, values: dict[str, list[float] | None], faults: list[Fault]
) -> None:
    """Add a fault if the arm is implausibly short or long; the message names the unit that was probably meant."""
    chain = sum(abs(length) for key in ("a", "d") for length in values[key] or ())
    if not chain or MIN_CHAIN <= chain <= MAX_CHAIN:
        return
    was, unit = ("mm", "m") if chain < MIN_CHAIN else ("m", "mm")
    there = [key for key in ("a", "d") if f"{key}_{was}" in table.columns]
    message = f"the links add up to {chain:g} m, which is no arm; correct the lengths"
    if there:
        columns, renamed = (", ".join(f"{key}_{name}" for key in there) for name in (was, unit))
        message += f", or, if they are in {unit}, call the column{'s'[: len(there) - 1]} {renamed} in place of {columns}"
    faults.append(Fault(path.name, message))


def _types(path: Path, table: Table, faults: list[Fault]) -> list[str]:
    """Return the type of each joint; all are revolute if the table has no such column."""
    types = [str(cell) for cell in table.columns.get(_TYPE, [_TYPES[0]] * table.n_rows)]
    for i, kind in enumerate(types):
        if kind not in _TYPES:
            message = f"{shorten(kind)} is no type of a joint; write {' or '.join(_TYPES)}"
            faults.append(Fault(path.name, message, int(table.line_numbers()[i]), _TYPE))
    return types


def _limits(
    path: Path, table: Table, types: Sequence[str], faults: list[Fault]
) -> Sequence[list[float] | None]:
    """Return the limits of each joint [rad; m for a prismatic joint], None where none are stated for its type."""
    found: list[list[float] | None] = [None] * table.n_rows
    for kind, units in (("revolute", _ANGLES), ("prismatic", _LENGTHS)):
        low, high = (_column(path, table.columns, key, units, False, faults) for key in _LIMITS)
        if (low is None) != (high is None):
            what = "angle" if kind == "revolute" else "travel"
            faults.append(
                Fault(
                    path.name,
                    f"a lowest {what} without a highest, or the other way round; give both, or none",
                )
            )
        if low is None or high is None:
            if kind == "prismatic" and low is high is None:
                _refuse_angles_of_slides(path, table, types, faults)
            continue
        for i in (i for i, type_ in enumerate(types) if type_ == kind):
            stated = [bound for bound in (low[i], high[i]) if not math.isnan(bound)]
            if len(stated) == 1:
                message = "one limit of the joint is empty; write both, or leave both empty"
                faults.append(Fault(path.name, message, int(table.line_numbers()[i])))
            elif stated and low[i] >= high[i]:
                message = "the lower limit is not below the upper; swap them"
                faults.append(Fault(path.name, message, int(table.line_numbers()[i])))
            elif stated:
                found[i] = stated
    return found


def _refuse_angles_of_slides(path: Path, table: Table, types: Sequence[str], faults: list[Fault]) -> None:
    """Add a fault for each joint that slides whose limits are stated as angles alone; zeros are taken for empty cells."""
    low, high = (_column(path, table.columns, key, _ANGLES, False, []) for key in _LIMITS)
    if low is None or high is None:
        return
    message = "this joint slides, so its limits are no angles; write them into columns lower_mm and upper_mm (or _m), and leave this cell empty"
    column = "lower_deg" if "lower_deg" in table.columns else "lower_rad"
    for i, kind in enumerate(types):
        if kind == "prismatic" and any(bound and not math.isnan(bound) for bound in (low[i], high[i])):
            faults.append(Fault(path.name, message, int(table.line_numbers()[i]), column))


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
