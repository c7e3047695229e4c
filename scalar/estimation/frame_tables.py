"""Tables of predicted frames: ``pose,x,y,z,rx,ry,rz``, and their uncertainties where asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.io.atomic import atomic_write
from scalar.estimation.result import PREDICTION_COLUMNS
from scalar.geometry.se3 import Array, log_so3

if TYPE_CHECKING:
    import pandas as pd

FRAME_COLUMNS = PREDICTION_COLUMNS[1:]
_PAIRS = [(i, j) for i in range(6) for j in range(i + 1, 6)]


def write_frames(path: Path, poses: Array, T: Array, covariance: Array | None = None) -> None:
    """Write frames as ``pose,x,y,z,rx,ry,rz`` [m, rotation vector rad], whole or not at all.

    Args:
        path: CSV file to write.
        poses: ``(N,)``, ids.
        T: ``(N, 4, 4)``.
        covariance: ``(N, 6, 6)`` of shift [m] and small turn [rad] in the base frame, or None. With it, the standard deviations
            ``x_std .. rz_std`` and the correlations ``x_y_correlation ..`` of every pair follow.
    """
    import pandas as pd

    values = np.concatenate([T[:, :3, 3], log_so3(T[:, :3, :3])], axis=1)
    table = pd.DataFrame(values, columns=list(FRAME_COLUMNS))
    table.insert(0, "pose", poses)
    if covariance is not None:
        table = pd.concat([table, _uncertainties(covariance)], axis=1)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.12g")


def _uncertainties(covariance: Array) -> pd.DataFrame:
    import pandas as pd

    std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    sizes = std[:, :, None] * std[:, None, :]
    correlation = np.divide(covariance, sizes, out=np.zeros_like(covariance), where=sizes > 0)
    columns = {f"{name}_std": std[:, i] for i, name in enumerate(FRAME_COLUMNS)}
    for i, j in _PAIRS:
        columns[f"{FRAME_COLUMNS[i]}_{FRAME_COLUMNS[j]}_correlation"] = correlation[:, i, j]
    return pd.DataFrame(columns)
