"""Tables of frames: ``pose,x,y,z,rx,ry,rz``, where asked for with their uncertainties and with their orientations in other forms."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.io.atomic import atomic_write
from scalar.data.io.semicolons import PLAIN, TextForm
from scalar.data.table_units import SI, TableUnits
from scalar.errors import Fault, InvalidInput
from scalar.estimation.result import PREDICTION_COLUMNS
from scalar.geometry.quaternions import quaternions_from_rotations, rotation_vectors_from_quaternions
from scalar.geometry.roll_pitch_yaw import rotation_from_rpy, rpy_from_rotation
from scalar.geometry.se3 import Array, log_so3

if TYPE_CHECKING:
    import pandas as pd

FRAME_COLUMNS = PREDICTION_COLUMNS[1:]
PLACE, VECTOR = tuple(FRAME_COLUMNS[:3]), tuple(FRAME_COLUMNS[3:])
ORIENTATIONS = {"rpy": ("roll", "pitch", "yaw"), "quaternion": ("qw", "qx", "qy", "qz")}
"""Other forms of an orientation, with their columns: ``R = Rz(yaw) Ry(pitch) Rx(roll)``, and the quaternion ``qw + qx i + qy j + qz k``."""
_PAIRS = [(i, j) for i in range(6) for j in range(i + 1, 6)]
_UNCERTAINTY = re.compile(r"(x|y|z|rx|ry|rz)_std(_mm|_deg)?|(x|y|z|rx|ry)_(y|z|rx|ry|rz)_correlation")


def is_frame_column(column: str) -> bool:
    """Return whether a column of this name holds a coordinate of a predicted frame, or its standard deviation or correlation."""
    return column in FRAME_COLUMNS or _UNCERTAINTY.fullmatch(column) is not None


def write_frames(
    path: Path,
    poses: Array,
    T: Array,
    covariance: Array | None = None,
    *,
    units: TableUnits = SI,
    orientation_known: bool = True,
    also: Sequence[str] = (),
    text_form: TextForm = PLAIN,
) -> None:
    """Write frames as ``pose,x,y,z,rx,ry,rz`` [m, rotation vector rad], whole or not at all.

    Args:
        path: CSV file to write.
        poses: ``(N,)``, ids.
        T: ``(N, 4, 4)``.
        covariance: ``(N, 6, 6)`` of shift [m] and small turn [rad] in the base frame, or None. With it, the standard deviations
            ``x_std .. rz_std`` and the correlations ``x_y_correlation ..`` of every pair follow.
        units: Of the numbers; where they are not SI, a column's name ends with its unit.
        orientation_known: Whether the measurements depend on the sensor's orientation on the flange. If not, that orientation is the
            declared one, and its uncertainty is left out, because the calibration has none.
        also: Names of further forms of the orientation, of ``ORIENTATIONS``; their columns follow ``rz``.
        text_form: How cells are separated and decimals are written.
    """
    import pandas as pd

    values = np.concatenate([T[:, :3, 3], log_so3(T[:, :3, :3])], axis=1)
    columns: dict[str, Array] = {"pose": poses}
    for i, name in enumerate(FRAME_COLUMNS):
        columns[units.named(name)] = values[:, i] / units.of(name)[1]
    units = units.turning(ORIENTATIONS["rpy"])
    for form in dict.fromkeys(also):
        for name, column in zip(ORIENTATIONS[form], _in_form(form, T[:, :3, :3]).T, strict=True):
            columns[units.named(name)] = column / units.of(name)[1]
    if covariance is not None:
        columns |= _uncertainties(covariance, units, len(FRAME_COLUMNS) if orientation_known else 3)
    with atomic_write(path) as temporary:
        text_form.write(pd.DataFrame(columns), temporary, "%.12g")


def _in_form(form: str, R: Array) -> Array:
    """Return rotations ``(N, 3, 3)`` as roll, pitch and yaw ``(N, 3)`` [rad], or as quaternions ``(N, 4)`` of norm 1 with ``qw >= 0``."""
    if form == "rpy":
        return np.array([rpy_from_rotation(each) for each in R]).reshape(-1, 3)
    return quaternions_from_rotations(R)


def form_of_orientation(columns: Iterable[str]) -> tuple[str, ...]:
    """Return the columns in which a table of frames states orientations: ``rx,ry,rz`` unless others are there and these are not."""
    there = set(columns)
    if not there.intersection(PLACE):  # a table of joint angles may have a column `roll` of another meaning
        return VECTOR
    forms = [VECTOR, *ORIENTATIONS.values()]
    return next((form for form in forms if there.intersection(form)), VECTOR)


def with_rotation_vectors(table: pd.DataFrame, form: Sequence[str], file: str) -> pd.DataFrame:
    """Return a table of frames with the columns ``rx,ry,rz`` [rad], from orientations in another form.

    Args:
        table: With ``pose`` and the columns of the form; angles in rad.
        form: The columns, as ``form_of_orientation`` returns them.
        file: Name of the file that is read, for the message.

    Raises:
        InvalidInput: A quaternion's norm is not 1.
    """
    values = table[list(form)].to_numpy(dtype=float)
    if tuple(form) == VECTOR:
        return table
    if tuple(form) == ORIENTATIONS["rpy"]:
        R = np.array([rotation_from_rpy(each) for each in values]).reshape(-1, 3, 3)
        return table.assign(**dict(zip(VECTOR, log_so3(R).T, strict=True)))
    vectors, wrong_norm = rotation_vectors_from_quaternions(values)
    for i in np.flatnonzero(~np.isnan(wrong_norm))[:1].tolist():
        pose, norm = table["pose"].iloc[i], f"{wrong_norm[i]:.4g}"
        message = f"the quaternion of pose {pose} has the norm {norm}, not 1; correct qw,qx,qy,qz"
        raise InvalidInput(Fault(file, message, i + 2, "qw"))
    return table.assign(**dict(zip(VECTOR, vectors.T, strict=True)))


def _uncertainties(covariance: Array, units: TableUnits, n: int) -> dict[str, Array]:
    """Return standard deviations and correlations of the first n columns of a frame."""
    std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    sizes = std[:, :, None] * std[:, None, :]
    correlation = np.divide(covariance, sizes, out=np.zeros_like(covariance), where=sizes > 0)
    columns: dict[str, Array] = {}
    for i, name in enumerate(FRAME_COLUMNS[:n]):
        unit, size = units.of(name)
        columns[f"{name}_std" if size == 1.0 else f"{name}_std_{unit}"] = std[:, i] / size
    for i, j in _PAIRS:
        if j < n:
            columns[f"{FRAME_COLUMNS[i]}_{FRAME_COLUMNS[j]}_correlation"] = correlation[:, i, j]
    return columns
