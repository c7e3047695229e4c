"""An arm in modified DH, written exactly as the rows of a standard-DH table.

``Rz(q + theta) Tz(d) Tx(a) Rx(alpha)`` ends a link where modified DH begins the next one, so that a and alpha of row i are those of joint
i + 1 in modified DH. Those of joint 1 go into the base's transform, before the first row; those of the last row are part of
the flange's transform. Hayati's beta follows alpha, as in modified DH: ``Rz(q + theta) Tz(d) Tx(a) Rx(alpha) Ry(beta)``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.geometry.robot import GEOMETRY, Robot, fixed_transform_mapping, link_end
from scalar.geometry.se3 import Array, transform_from_rotation_vector

AFTER_THE_JOINT = ("a", "alpha", "beta")
"""Parameters of joint i + 1 in modified DH that stand in row i of a standard-DH table."""
OF_THE_BASE = "of the base"
_A, _ALPHA = GEOMETRY.index("a"), GEOMETRY.index("alpha")
_OF_A_ROW = re.compile(rf"({'|'.join(GEOMETRY)}) (\d+|{OF_THE_BASE})")
_NAME = re.compile(rf"\b({'|'.join(GEOMETRY)})_(\d+)\b")


@dataclass(frozen=True, eq=False)
class StandardTable:
    """An arm in standard DH.

    Attributes:
        rows: ``(5, n)``, rows as in ``GEOMETRY``; a [m], alpha and beta [rad] of a row act after the joint.
        T_base_0: ``(4, 4)``, fixed transform before the first row.
        T_n_flange: ``(4, 4)``, fixed transform after the last row.
    """

    rows: Array
    T_base_0: Array
    T_n_flange: Array


def standard_rows(values: Array, end: tuple[float, float, float]) -> Array:
    """Return values ``(5, n)``, one for each parameter of modified DH, in the rows of a standard-DH table.

    Args:
        values: ``(5, n)``, the parameters or, for example, their standard deviations.
        end: Values of a, alpha and beta in the last row.
    """
    rows = values.copy()
    for kind, last in zip(AFTER_THE_JOINT, end, strict=True):
        k = GEOMETRY.index(kind)
        rows[k] = np.r_[values[k, 1:], last]
    return rows


def standard_table(robot: Robot) -> StandardTable:
    """Return an arm in standard DH; a and alpha of its last row are those of the table that it was read from, else zero."""
    a, alpha, beta = (float(robot.geometry[GEOMETRY.index(kind), 0]) for kind in AFTER_THE_JOINT)
    end = robot.standard_end or (0.0, 0.0)
    return StandardTable(
        standard_rows(robot.geometry, (*end, 0.0)),
        robot.T_base_0 @ link_end(a, alpha) @ transform_from_rotation_vector([0.0] * 3, [0.0, beta, 0.0]),
        np.linalg.inv(link_end(*end)) @ robot.T_n_flange,
    )


def read_as_standard(robot: Robot) -> Robot:
    """Return the arm whose modified-DH table is read as standard DH: every link's a and alpha act after its joint."""
    geometry = robot.geometry.copy()
    a, alpha = geometry[_A].copy(), geometry[_ALPHA].copy()
    geometry[_A], geometry[_ALPHA] = np.r_[0.0, a[:-1]], np.r_[0.0, alpha[:-1]]
    end = float(a[-1]), float(alpha[-1])
    return replace(robot, geometry=geometry, T_n_flange=link_end(*end) @ robot.T_n_flange, standard_end=end)


def read_as_modified(robot: Robot) -> Robot:
    """Return the arm whose standard-DH table, already converted, is read as modified DH: a and alpha act before their joint."""
    table = standard_table(robot)
    return replace(robot, geometry=table.rows, T_n_flange=table.T_n_flange, standard_end=None)


def stated_mapping(robot: Robot) -> dict[str, Any]:
    """Return the ``robot:`` block of a dataset in the convention of the table that the arm was read from.

    A standard-DH table has no beta, and neither has a nominal arm that was read from one, so nothing is lost.
    """
    mapping = robot.to_mapping()
    if not robot.standard_dh:
        return mapping
    table = standard_table(robot)
    joints = [
        {kind: float(value) + 0.0 for kind, value in zip(GEOMETRY, row, strict=True) if kind != "beta"}
        | {key: joint[key] for key in ("limits", "type") if key in joint}
        for row, joint in zip(table.rows.T, mapping["joints"], strict=True)
    ]
    return mapping | {
        "convention": "standard-dh",
        "joints": joints,
        "base": fixed_transform_mapping(table.T_base_0),
        "flange": fixed_transform_mapping(table.T_n_flange),
    }


def without_beta(robot: Robot) -> Robot:
    """Return the arm that a standard-DH table can describe: without beta, except that of joint 1, which goes into the base's transform."""
    geometry = robot.geometry.copy()
    geometry[GEOMETRY.index("beta"), 1:] = 0.0
    return replace(robot, geometry=geometry)


def in_rows(text: str, robot: Robot) -> str:
    """Return a text in which parameters are named by the rows of the table that the arm was read from: ``a 1`` instead of ``a_2`` for standard DH.

    These names are written with a space, the model's own with an underscore, so that neither is taken for the other. What precedes the table's first
    row is part of the base.
    """

    def row(found: re.Match[str]) -> str:
        kind, joint = found[1], int(found[2])
        return in_row(kind, joint - (robot.standard_dh and kind in AFTER_THE_JOINT))

    return _NAME.sub(row, text)


def as_stated(text: str, robot: Robot) -> str:
    """Return a text in which parameters are named as in the table that the arm was read from: by its rows if that is standard DH."""
    return in_rows(text, robot) if robot.standard_dh else text


def from_row(name: str, robot: Robot) -> str:
    """Return the model's name of a parameter that is named by a row, ``a_3`` for ``a 2`` of standard DH; any other text as it is.

    The inverse of ``as_stated`` for one name.
    """
    found = _OF_A_ROW.fullmatch(name)
    if found is None or not robot.standard_dh:
        return name
    row = 0 if found[2] == OF_THE_BASE else int(found[2])
    parameter = f"{found[1]}_{row + (found[1] in AFTER_THE_JOINT)}"
    return parameter if parameter in robot.parameter_names else name


def in_row(kind: str, row: int) -> str:
    """Return the name of a parameter of a row, from 1; row 0 is what precedes the table's first row."""
    return f"{kind} {row}" if row else f"{kind} {OF_THE_BASE}"
