"""Tables of the parameters in the rows of the robot's own DH table, in millimetres and degrees.

Their columns are the value in the data sheet, the estimated value, the change and its standard error.

The model is in modified DH. If dataset.yaml has a standard-DH table, a and alpha of its row i are those of joint i + 1 in modified DH, because they
act after joint i. The a and alpha of the last row of such a table are part of the flange, which is not calibrated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from scalar.effects.wording import stiffness_row
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.evaluate import rotation_vector_near
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
from scalar.geometry.se3 import Array, log_so3
from scalar.geometry.standard_dh import AFTER_THE_JOINT, in_row, in_rows
from scalar.report.words import UNKNOWN
from scalar.robots import axis_in_brackets, axis_names_of
from scalar.units import DEG, MM

_BEYOND_CHANCE = 1.96  # standard errors: chance alone exceeds them one time in twenty
LAST_ROW = "part of the flange: only their combination with the sensor's place on it is determined"
"""Why a and alpha of the last row of a standard-DH table are not calibrated."""
DATA_SHEET, STATED = "data sheet", "stated"
_RPY = "roll pitch yaw: Rz(yaw) Ry(pitch) Rx(roll)"
_LEAST_DECIMALS, _MOST_DECIMALS = 3, 6


def parameter_tables(calibration: Calibration, T_flange_sensor: Array | None) -> list[dict[str, Any]]:
    """Return the tables of lengths, of angles and of the sensor's place, with their rows.

    Args:
        calibration: The calibration to report.
        T_flange_sensor: ``(4, 4)``, the sensor's pose on the flange that the dataset states, or None.
    """
    names = axis_names_of(calibration.model.nominal)
    entries = list(_geometry(calibration, names))
    tables = [
        _table("Lengths", "mm", DATA_SHEET, [entry[1:] for entry in entries if entry[0] in LENGTHS]),
        _table("Angles", "°", DATA_SHEET, [entry[1:] for entry in entries if entry[0] not in LENGTHS]),
        _stiffnesses(calibration, names),
        *_sensor(calibration, T_flange_sensor),
    ]
    return [table for table in tables if table["rows"]]


def convention_in_words(robot: Robot) -> str:
    """Return the sentence that says which convention of Denavit-Hartenberg parameters the tables use, and what stands in brackets behind a joint."""
    convention, order = (
        ("standard", "Rz(q + theta) Tz(d) Tx(a) Rx(alpha)")
        if robot.standard_dh
        else ("modified", "Rx(alpha) Tx(a) Rz(q + theta) Tz(d)")
    )
    axes = " In brackets stands what the maker calls the axis of the joint." if axis_names_of(robot) else ""
    return f"Denavit-Hartenberg parameters ({convention}), as in dataset.yaml: {order}.{axes}"


def gauge_rows(calibration: Calibration) -> list[dict[str, Any]]:
    """Return what was fixed, why, and what it is confounded with, named by the rows of the robot's own table.

    a and alpha of the last row of a standard-DH table are part of the flange and no parameters of the model; they come last.
    """
    nominal = calibration.model.nominal
    rows = [
        {
            "held": in_rows(entry["held"], nominal),
            "reason": in_rows(entry["reason"], nominal),
            "moves_with": [in_rows(name, nominal) for name in entry["moves_with"]],
        }
        for entry in calibration.gauge
    ]
    if nominal.standard_dh:
        n = nominal.n_joints
        rows.append({"held": f"a {n}, alpha {n}", "reason": LAST_ROW, "moves_with": []})
    return rows


Entry = tuple[str, float | None, float, float | None, str]
"""A row of a table: name, nominal value, found value, standard error, all in the unit of the table, and a remark."""


def _geometry(
    calibration: Calibration, names: Sequence[str]
) -> Iterator[tuple[str, str, float | None, float, float | None, str]]:
    """Yield the kind (``a``, ``alpha`` ...) and the ``Entry`` of every geometric parameter of the robot's own table, row by row.

    Args:
        calibration: The calibration to report.
        names: The maker's names of the axes of all joints, or none.
    """
    robot, nominal, std = calibration.model.robot, calibration.model.nominal, calibration.std
    freed = _freed_by_effects(calibration)
    near = calibration.summary.get("kept_near_data_sheet") or {}
    for row in range(0 if nominal.standard_dh else 1, robot.n_joints + 1):
        for k, kind in enumerate(GEOMETRY):
            # A row of a standard-DH table has a, alpha and beta of the model's next joint; row 0 has nothing else.
            joint = row + 1 if nominal.standard_dh and kind in AFTER_THE_JOINT else row
            name = f"{kind}_{joint}"
            added, error, effect = freed.get(name, (0.0, std.get(name), ""))
            known = name in std or name in freed
            if not 1 <= joint <= robot.n_joints or (not known and (kind == "beta" or row == 0)):
                continue
            unit = MM if kind in LENGTHS else DEG
            stated, found = (float(x.geometry[k, joint - 1]) / unit for x in (nominal, robot))
            found += added / unit
            error = None if error is None else float(error) / unit
            remark = "fixed" if error is None else "near data sheet" if name in near else effect
            yield kind, in_row(kind, row) + axis_in_brackets(names, [row]), stated, found, error, remark


def _freed_by_effects(calibration: Calibration) -> dict[str, tuple[float, float | None, str]]:
    """Return value and standard error of what effects add to single parameters that the model itself has fixed (beta), and the effects' titles."""
    found: dict[str, tuple[float, float | None, str]] = {}
    for effect, error in zip(calibration.model.effects, calibration.effect_std, strict=True):
        if effect.frees:
            found[f"{effect.frees}_{effect.target['joint']}"] = (
                float(effect.coefficients[0]),
                error[0],
                effect.title,
            )
    return found


def _stiffnesses(calibration: Calibration, names: Sequence[str]) -> dict[str, Any]:
    """Return the table of the joints' stiffnesses, for effects of which the torque is known; without rows where there are none."""
    found = [
        (row[0], stiffness_row(*row))
        for effect, names in zip(calibration.model.effects, calibration.model.effect_names, strict=True)
        for row in effect.stiffness([calibration.std.get(name) for name in names])
    ]
    rows = [
        {
            "name": name.removesuffix(" stiffness") + axis_in_brackets(names, [joint]),
            "nominal": UNKNOWN,
            "found": value,
            "change": UNKNOWN,
            "error": error,
            "remark": "",
            "beyond_chance": False,
        }
        for joint, (name, value, error, _) in found
    ]
    return {"title": "Stiffness of the joints", "unit": "N m/rad", "source": DATA_SHEET, "rows": rows}


def _sensor(calibration: Calibration, T_stated: Array | None) -> Iterator[dict[str, Any]]:
    """Yield the tables of the sensor's pose on the flange: its translation, and its rotation vector if the data observe it."""
    std = calibration.std
    model = calibration.model
    turn, stated = model.sensor_rotation_vector(), None
    if T_stated is not None:
        turn_stated = log_so3(T_stated[:3, :3])
        turn, stated = rotation_vector_near(turn, turn_stated), np.r_[T_stated[:3, 3], turn_stated]
    found = np.r_[model.sensor[:3], turn]
    for names, unit, words in ((("x", "y", "z"), MM, "mm"), (("rx", "ry", "rz"), DEG, "°")):
        entries: list[Entry] = []
        for name in names:
            i = ("x", "y", "z", "rx", "ry", "rz").index(name)
            error = std.get(f"sensor_{name}")
            if error is None and words == "°" and not calibration.observes_orientation:
                continue
            entries.append(
                (
                    name,
                    None if stated is None else float(stated[i]) / unit,
                    float(found[i]) / unit,
                    None if error is None else float(error) / unit,
                    "fixed" if error is None else "",
                )
            )
        yield _table(
            "Sensor on the flange" + (", rotation vector" if words == "°" else ""), words, STATED, entries
        )
        if words == "°" and entries:
            yield _table(f"Sensor on the flange, {_RPY}", words, STATED, _roll_pitch_yaw(model, T_stated))


def _roll_pitch_yaw(model: Model, T_stated: Array | None) -> list[Entry]:
    """Return the rows of the same rotation as a person reads it; its standard errors are those of the rotation vector."""
    found = rpy_from_rotation(model.T_flange_sensor[:3, :3]) / DEG
    stated = None if T_stated is None else rpy_from_rotation(T_stated[:3, :3]) / DEG
    return [
        (name, None if stated is None else float(stated[i]), float(found[i]), None, UNKNOWN)
        for i, name in enumerate(("roll", "pitch", "yaw"))
    ]


def _table(title: str, unit: str, source: str, entries: list[Entry]) -> dict[str, Any]:
    """Return a table for the template; ``source`` says where the nominal values come from."""
    errors = [entry[3] for entry in entries if entry[3]]
    # Two digits of the smallest standard error: with fewer, a change could not be compared with it.
    finest = 1 - int(np.floor(np.log10(min(errors)))) if errors else _LEAST_DECIMALS
    decimals = int(np.clip(finest, _LEAST_DECIMALS, _MOST_DECIMALS))
    return {
        "title": title,
        "unit": unit,
        "source": source,
        "rows": [_row(entry, decimals) for entry in entries],
    }


def _row(entry: Entry, decimals: int) -> dict[str, Any]:
    name, nominal, found, error, remark = entry
    change = None if nominal is None else found - nominal
    return {
        "name": name,
        "nominal": UNKNOWN if nominal is None else _fixed(nominal, decimals),
        "found": _fixed(found, decimals),
        "change": UNKNOWN if change is None or error is None else _signed(change, decimals),
        "error": remark if error is None else f"{error:.{decimals}f}",
        "remark": "" if error is None else remark,
        "beyond_chance": change is not None and error is not None and abs(change) > _BEYOND_CHANCE * error,
    }


def _fixed(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")


def _signed(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:+.{decimals}f}".replace("-", "−")
