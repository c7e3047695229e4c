"""Tables of joint angles to predict for, tables of predicted frames, and the folder of a simulated truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.atomic import atomic_write
from scalar.calibration import PREDICTION_COLUMNS
from scalar.errors import Fault, InvalidInput
from scalar.se3 import Array, log_so3

FRAME_COLUMNS = PREDICTION_COLUMNS[1:]


def read_joints(path: Path, n_joints: int, required: tuple[str, ...] = ()) -> pd.DataFrame:
    """Return a table with ``pose, q1..qn`` and whatever numeric columns it has beside them.

    Args:
        path: Of a CSV file.
        n_joints: Of the robot.
        required: Further columns that must be there.

    Raises:
        InvalidInput: With every fault found.
    """
    wanted = ["pose", *(f"q{i + 1}" for i in range(n_joints)), *required]
    try:
        table = pd.read_csv(path)
    except FileNotFoundError:
        raise InvalidInput([Fault(str(path), "no such file")]) from None
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise InvalidInput([Fault(path.name, f"not a CSV table: {str(error).strip()}")]) from None
    faults = [
        Fault(path.name, f"the column is missing; this robot has {n_joints} joints", 1, name)
        for name in wanted
        if name not in table.columns
    ]
    surplus = f"q{n_joints + 1}"
    if surplus in table.columns:
        faults.append(Fault(path.name, f"this robot has only {n_joints} joints", 1, surplus))
    if faults:
        raise InvalidInput(faults)
    for name in wanted:
        values = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=float)
        for row in np.flatnonzero(~np.isfinite(values))[:20]:
            written = table[name].iloc[row]
            faults.append(Fault(path.name, f"not a finite number ({written!r})", int(row) + 2, name))
    if faults:
        raise InvalidInput(faults)
    return table


def write_frames(path: Path, poses: Array, T: Array) -> None:
    """Write frames ``(N, 4, 4)`` as ``pose,x,y,z,rx,ry,rz`` [m, rotation vector rad], whole or not at all."""
    values = np.concatenate([T[:, :3, 3], log_so3(T[:, :3, :3])], axis=1)
    table = pd.DataFrame(values, columns=list(FRAME_COLUMNS))
    table.insert(0, "pose", poses)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.12g")


def read_truth(folder: Path, n_joints: int) -> tuple[pd.DataFrame, dict[str, Any] | None]:
    """Return the true poses of a simulated set and the content of its ``truth.json``, or None where that is missing.

    Raises:
        InvalidInput: There are no true poses, or a file is damaged.
    """
    poses = read_joints(folder / "truth_poses.csv", n_joints, FRAME_COLUMNS)
    path = folder / "truth.json"
    if not path.exists():
        return poses, None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InvalidInput([Fault(str(path), f"not JSON: {error}")]) from None
    if not isinstance(content, dict):
        raise InvalidInput([Fault(str(path), "not a truth: expected a mapping")])
    return poses, content
