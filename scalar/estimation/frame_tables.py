"""Tables of predicted frames: ``pose,x,y,z,rx,ry,rz``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scalar.data.io.atomic import atomic_write
from scalar.estimation.result import PREDICTION_COLUMNS
from scalar.geometry.se3 import Array, log_so3

FRAME_COLUMNS = PREDICTION_COLUMNS[1:]


def write_frames(path: Path, poses: Array, T: Array) -> None:
    """Write frames ``(N, 4, 4)`` as ``pose,x,y,z,rx,ry,rz`` [m, rotation vector rad], whole or not at all."""
    import pandas as pd

    values = np.concatenate([T[:, :3, 3], log_so3(T[:, :3, :3])], axis=1)
    table = pd.DataFrame(values, columns=list(FRAME_COLUMNS))
    table.insert(0, "pose", poses)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.12g")
