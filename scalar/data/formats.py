"""Versions of the dataset's format: which are read, which is written, and what the newest defines that is not read yet.

Version 1 keeps every numeric column that it does not know, as a covariate. Version 2 gives some of these names a meaning: commanded
joint positions (``qc1..qcn``), which may be used in place of those logged; joint torques and the payload, which are covariates. What
version 2 defines and this release does not act upon is refused, since to ignore it would give a wrong answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scalar.errors import Fault

DATASET_FORMAT = "scalar-dataset/2"
"""The version that is written."""
DATASET_FORMATS = ("scalar-dataset/1", DATASET_FORMAT)
"""The versions that are read."""

COMMANDED, TORQUE = "qc", "tau"
"""Columns of poses.csv, one for each joint: the commanded position [rad, m] and the torque [N m, N]."""
PAYLOAD = ("payload", "payload_x", "payload_y", "payload_z")
"""Columns of poses.csv: the payload's mass [kg], and where it sits in the flange's frame [m]."""
_FILES = ("nests.csv", "nests.parquet")


def refuse_files(format: Any, names: Sequence[str]) -> list[Fault]:
    """Return a fault for every file that this format defines and that is not read yet."""
    if format != DATASET_FORMAT:
        return []
    message = f"{format} defines this file, and this release does not support it yet; remove it"
    return [Fault(name, message) for name in names if name in _FILES]
