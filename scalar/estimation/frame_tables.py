"""Tables of predicted frames: ``pose,x,y,z,rx,ry,rz``, and their uncertainties where asked for."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from scalar.data.io.atomic import atomic_write
from scalar.data.table_units import SI, TableUnits
from scalar.estimation.result import PREDICTION_COLUMNS
from scalar.geometry.se3 import Array, log_so3

FRAME_COLUMNS = PREDICTION_COLUMNS[1:]
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
    """
    import pandas as pd

    values = np.concatenate([T[:, :3, 3], log_so3(T[:, :3, :3])], axis=1)
    columns: dict[str, Array] = {"pose": poses}
    for i, name in enumerate(FRAME_COLUMNS):
        columns[units.named(name)] = values[:, i] / units.of(name)[1]
    if covariance is not None:
        columns |= _uncertainties(covariance, units, len(FRAME_COLUMNS) if orientation_known else 3)
    with atomic_write(path) as temporary:
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.12g")


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
