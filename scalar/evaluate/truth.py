"""Read the truth of a simulated dataset: the folder that ``scalar simulate`` writes next to the dataset."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.io.json_reader import read_json
from scalar.data.io.run_id import RUN, check_truth_run
from scalar.data.pose_tables import read_pose_table
from scalar.errors import Fault, InvalidInput
from scalar.estimation.frame_tables import FRAME_COLUMNS
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import pandas as pd


def read_truth(
    folder: Path, n_joints: int, limits: Array | None = None, prismatic: Sequence[int] = ()
) -> tuple[pd.DataFrame, dict[str, Any] | None]:
    """Return the true poses of a simulated dataset and the content of its ``truth.json``, None where that file is missing.

    Args:
        folder: With ``truth_poses.csv``.
        n_joints: Number n of joints of the robot.
        limits: ``(n, 2)`` [rad, m], which the joints of the true poses must keep; or None.
        prismatic: Indices, from 0, of the prismatic joints.

    Raises:
        InvalidInput: There are no true poses, or a file is damaged.
    """
    poses = read_pose_table(folder / "truth_poses.csv", n_joints, FRAME_COLUMNS, limits, prismatic=prismatic)
    path = folder / "truth.json"
    if not path.exists():
        return poses, None
    content = read_json(path)
    try:
        _check_truth(content)
    except (TypeError, ValueError, KeyError, AttributeError):
        message = "not a truth: expected 'parameters' and 'planes' as 'scalar simulate' writes them"
        raise InvalidInput([Fault(str(path), message)]) from None
    check_truth_run(folder, content.get(RUN))
    return poses, content


def _check_truth(content: dict[str, Any]) -> None:
    """Convert the numbers of a truth to arrays, and let the error of NumPy or Python pass where one cannot be converted."""
    parameters, planes = content.get("parameters", {}), content.get("planes")
    for key in (*GEOMETRY, "t", "r"):
        np.array(parameters.get(key, []), dtype=float).reshape(-1)
    if planes is not None:
        normals = np.array(planes["normals"], dtype=float).reshape(-1, 3)
        np.array(planes["distances"], dtype=float).reshape(len(normals))
