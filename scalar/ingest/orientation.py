"""Convert orientations of measured targets from Euler angles or quaternions of foreign tables to the rotation vectors of a dataset.

Euler angles turn about the axes in the order in which ``axes`` names them, ``e1`` about the first: capitals about the moving axes (intrinsic, as in
KUKA's A, B, C: ZYX), small letters about the fixed ones (extrinsic). A quaternion is ``qw + qx i + qy j + qz k``; q and -q are the same rotation.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from scalar.data.description import Description
from scalar.errors import Fault
from scalar.geometry.quaternions import rotation_vectors_from_quaternions
from scalar.geometry.se3 import Array
from scalar.ingest.imported_table import ImportedTable

VECTOR = ("rx", "ry", "rz")
EULER = ("e1", "e2", "e3")
QUATERNION = ("qw", "qx", "qy", "qz")
_ROUNDING = 1e-2  # rad, of an angle of a whole turn


def wrong_axes(axes: Any) -> str | None:
    """Return the message about a fault of the axes of Euler angles, or None."""
    known = isinstance(axes, str) and len(axes) == 3 and (set(axes) <= set("xyz") or set(axes) <= set("XYZ"))
    if not known or axes[0] == axes[1] or axes[1] == axes[2]:
        return f"axes {axes!r} are not three such as XYZ (about moving axes) or xyz (about fixed axes)"
    return None


def check_orientation(given: Description, key: str) -> None:
    """Add the faults of the columns and axes of orientation in a block of a mapping to ``given.faults``."""
    columns, axes = given.get(key, "columns"), given.get(key, "euler_axes")
    groups = [names for names in (VECTOR, EULER, QUATERNION) if set(names) & set(columns)]
    if len(groups) > 1:
        message = (
            f"{' and '.join(','.join(g) for g in groups)} state the same orientation twice; keep one of them"
        )
        given.fault((key, "columns"), message)
    for names in groups:
        for name in names:
            if name not in columns:
                given.fault((key, "columns", name), f"missing; add it: {','.join(names)} come together")
    if EULER in groups and axes is None:
        message = "missing; add it: ZYX where e1, e2, e3 turn about the moving axes z, y, x (as KUKA's A, B, C), zyx about the fixed ones"
        given.fault((key, "euler_axes"), message)
    if axes is not None:
        wrong = wrong_axes(axes)
        if EULER not in groups:
            given.fault(
                (key, "euler_axes"), "there are no columns e1,e2,e3 here; add them, or remove this key"
            )
        elif wrong:
            given.fault((key, "euler_axes"), wrong)


def _report_degrees(table: ImportedTable, angles: Array, faults: list[Fault]) -> None:
    """Add a fault if Euler angles ``(N, 3)`` [rad] are so large that they are degrees; an angle of more than a turn is written by no program."""
    row, k = np.unravel_index(int(np.argmax(np.nan_to_num(np.abs(angles)))), angles.shape)
    if abs(angles[row, k]) > 2 * np.pi + _ROUNDING:
        table.report(
            faults,
            EULER[k],
            np.arange(len(angles)) == row,
            lambda i: (
                f"an Euler angle of {angles[i, k]:.4g} rad is more than a turn; if the file has degrees, write unit: deg for {', '.join(EULER)}"
            ),
        )


def to_rotation_vectors(table: ImportedTable, axes: str | None, faults: list[Fault]) -> None:
    """Replace Euler angles [rad] or quaternions by ``rx,ry,rz`` [rad], in place; a quaternion whose norm is not 1 is a fault of its row."""
    columns = table.columns
    if EULER[0] in columns and axes is not None:
        names, angles = EULER, np.column_stack([columns[name] for name in EULER])
        _report_degrees(table, angles, faults)
        vectors = Rotation.from_euler(axes, np.nan_to_num(angles)).as_rotvec()
    elif QUATERNION[0] in columns:
        names, q = QUATERNION, np.column_stack([columns[name] for name in QUATERNION])
        vectors, wrong_norm = rotation_vectors_from_quaternions(q)
        table.report(
            faults,
            "qw",
            ~np.isnan(wrong_norm),
            lambda i: f"the quaternion has the norm {wrong_norm[i]:.4g}, not 1; correct the four columns",
        )
    else:
        return
    for k, name in enumerate(VECTOR):
        columns[name] = vectors[:, k]
        table.labels[name] = ",".join(table.labels[given] for given in names)
    for name in names:
        del columns[name]
