"""A campaign as its files have it: the description, joint angles, labels and measured points; and where its table of joints puts the flange.

Nothing here calls the estimator's formulas.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset_writer import write_dataset
from study.common.kinematics import (
    PARAMETER_KINDS,
    chain,
    joint_names,
    pose_mapping,
    rotation,
    standard_chain,
    transform,
    translation,
)

MODIFIED, STANDARD = "modified-dh", "standard-dh"


@dataclass(frozen=True, eq=False)
class Campaign:
    """What the files of a dataset hold.

    Attributes:
        robot: The ``robot:`` block of dataset.yaml.
        sensor: The ``sensor:`` block.
        planes: The ``planes:`` block; empty before a tracker.
        q: Joint angles ``(N, n)`` [rad].
        labels: Name of the plane of each pose; empty before a tracker.
        points: What was measured at each pose ``(m, 2)`` or ``(1, 3)`` [m].
    """

    robot: Mapping[str, Any]
    sensor: Mapping[str, Any]
    planes: tuple[Mapping[str, Any], ...]
    q: np.ndarray
    labels: tuple[str, ...]
    points: tuple[np.ndarray, ...]

    def of_rows(self, angles: Sequence[int], measured: Sequence[int], labels: Sequence[int]) -> Campaign:
        """Return the campaign whose rows have the angles, the measurements and the labels of these rows of this one."""
        return replace(
            self,
            q=self.q[list(angles)],
            points=tuple(self.points[i] for i in measured),
            labels=tuple(self.labels[i] for i in labels) if self.labels else (),
        )

    def write(self, folder: Path) -> Path:
        """Write the folder of the dataset and return its path."""
        ids = np.arange(1, len(self.q) + 1)
        poses = pd.DataFrame(self.q, columns=joint_names(self.q.shape[1]))
        poses.insert(0, "pose", ids)
        mapping = {
            "format": "scalar-dataset/2",
            "name": "set-up",
            "robot": dict(self.robot),
            "sensor": dict(self.sensor),
        }
        columns, table = ("x", "y", "z"), "points"
        if self.labels:
            poses.insert(1, "plane", np.array(self.labels, dtype=object))
            mapping["planes"] = [dict(plane) for plane in self.planes]
            columns, table = ("x", "z"), "scans"
        of_pose = np.repeat(ids, [len(points) for points in self.points])
        values = np.concatenate(self.points)
        measured = pd.DataFrame({"pose": of_pose, **dict(zip(columns, values.T, strict=True))})
        write_dataset(folder, mapping=mapping, poses=poses, **{table: measured})
        return folder


def flange_frames(robot: Mapping[str, Any], q: np.ndarray) -> np.ndarray:
    """Return ``T_base_flange`` ``(N, 4, 4)`` by the ``robot:`` block of a dataset, at joint angles ``(N, n)`` [rad]."""
    base, flange = transform(robot.get("base")), transform(robot.get("flange"))
    joints = robot["joints"]
    if robot["convention"] == STANDARD:
        rows = [
            tuple(float(joint.get(kind, 0.0)) for kind in ("theta", "d", "a", "alpha")) for joint in joints
        ]
        return base @ standard_chain(rows, q) @ flange
    return chain(geometry_of(robot), q, base) @ flange


def geometry_of(robot: Mapping[str, Any]) -> np.ndarray:
    """Return the numbers of a table of joints ``(5, n)`` in the order of ``PARAMETER_KINDS`` [m, rad]."""
    return np.array([[float(joint.get(kind, 0.0)) for joint in robot["joints"]] for kind in PARAMETER_KINDS])


def with_geometry(robot: Mapping[str, Any], geometry: np.ndarray) -> dict[str, Any]:
    """Return a ``robot:`` block with other numbers ``(5, n)`` in its table."""
    columns = [dict(zip(PARAMETER_KINDS, map(float, column), strict=True)) for column in geometry.T]
    joints = [joint | column for joint, column in zip(robot["joints"], columns, strict=True)]
    return {**robot, "joints": joints}


def in_standard_rows(robot: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same arm with a table of standard DH.

    A row of it has the ``a`` and ``alpha`` of the next row of modified DH. Those of the first row are part of the base, and the last row has none.
    """
    joints = robot["joints"]
    first = joints[0]
    base = transform(robot.get("base")) @ rotation(0, first["alpha"]) @ translation(0, first["a"])
    rows = []
    for i, joint in enumerate(joints):
        following = joints[i + 1] if i + 1 < len(joints) else {"a": 0.0, "alpha": 0.0}
        row = {"a": following["a"], "alpha": following["alpha"], "d": joint["d"], "theta": joint["theta"]}
        rows.append(row | {"limits": joint["limits"]})
    block = {**robot, "convention": STANDARD, "joints": rows}
    return block if np.allclose(base, np.eye(4)) else block | {"base": pose_mapping(base)}
