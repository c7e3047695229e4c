"""Tables of poses outside a dataset: poses to predict for, and true poses.

They have the columns of poses.csv except ``plane``, and are checked as strictly. Their cells may be separated by semicolons, with decimal commas.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.description import DESCRIPTION, Description
from scalar.data.io.csv_reader import read_csv
from scalar.data.table_consistency import check_poses, poses_layout
from scalar.data.table_units import SI, FileUnits, TableUnits, columns_of
from scalar.data.unit_suspicions import suspect_joint_angles
from scalar.errors import Fault, InvalidInput

if TYPE_CHECKING:
    import pandas as pd

    from scalar.data.joint_convention import JointConvention

# A calibration holds the limits of the dataset from which it was made.
_GIVE_LIMITS = f"give its limits in {DESCRIPTION} of the dataset and calibrate again"


def read_pose_table(
    path: str | os.PathLike[str],
    n_joints: int,
    required: tuple[str, ...] = (),
    limits: np.ndarray | None = None,
    *,
    units: TableUnits = SI,
    joints_needed: bool = True,
    prismatic: Sequence[int] = (),
    columns: Sequence[str] | None = None,
    copied: bool = False,
    convention: JointConvention | None = None,
) -> pd.DataFrame:
    """Return the poses of a CSV file with the columns ``pose, q1..qn``, joints as the dataset counts them; rows and columns as in the file.

    Args:
        path: the file.
        n_joints: how many joints the robot has.
        required: further numeric columns that have to be there; all others are kept.
        limits: ``(n_joints, 2)`` [rad, m], the robot's, if known; angles within them are never suspected to be degrees.
        units: units of joint angles, positions and rotation vectors whose columns do not state their own.
        joints_needed: whether the columns q1..qn have to be there.
        prismatic: indices, from 0, of the prismatic joints.
        columns: the names in the file's first line, if they were read before.
        copied: whether further columns may hold text or empty cells.
        convention: how the controller counts the joints of the file; None if they count as those of the dataset.

    Returns:
        `pose` int64, `plane` and `session` text, with `copied` also columns that are not all numbers, all others float64;
        in SI, under the names without units.

    Raises:
        InvalidInput: with every fault found, each with its row and column.
    """
    path = Path(path)
    description = _description(n_joints, limits, prismatic)
    known = poses_layout(description)
    needed = known.required if joints_needed else ("pose",)
    columns = columns_of(path) if columns is None else columns
    own = FileUnits.of(columns, units.sliding(prismatic))
    layout = own.layout(replace(known, required=(*needed, *required), copied=copied, semicolons=True))
    faults: list[Fault] = []
    table = read_csv(path, layout, faults)
    if table is not None:
        own.to_si(table)
        if convention is not None:
            convention.table_to_dataset(table)
        # Only `pose` is unique: several poses to predict for may have the same order.
        # An effect of one joint needs the approach of that joint alone.
        check_poses(table, description, faults, unique=("pose",), all_joints=False)
        suspect_joint_angles(table, description, faults, give_limits=_GIVE_LIMITS)
    if faults or table is None:
        raise InvalidInput(faults)
    import pandas as pd

    frame = pd.DataFrame(table.columns)
    frame["pose"] = frame["pose"].astype(np.int64)
    return frame


def _description(n_joints: int, limits: np.ndarray | None, prismatic: Sequence[int]) -> Description:
    """Return a description of the joints alone, by which tables are checked; arguments as above."""
    joints: list[dict[str, Any]] = [
        {} if limits is None else {"limits": [float(x) for x in limits[i]]} for i in range(n_joints)
    ]
    for i in prismatic:
        joints[i]["type"] = "prismatic"
    return Description({"robot": {"joints": joints}}, {})
