"""Versions of the dataset's format: which are read, which is written, and what the newest defines that is not read yet.

Version 1 keeps every numeric column that it does not know, as a covariate. Version 2 gives some of these names a meaning; until
that meaning is acted upon, a dataset of version 2 that has them is refused, since to ignore them would give a wrong answer.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from scalar.errors import Fault

DATASET_FORMAT = "scalar-dataset/2"
"""The version that is written."""
DATASET_FORMATS = ("scalar-dataset/1", DATASET_FORMAT)
"""The versions that are read."""

_POSE_COLUMNS = re.compile(r"(qc|tau)[1-9][0-9]*|payload(_[xyz])?")
_FILES = ("nests.csv", "nests.parquet")


def refuse_pose_column(format: Any, name: str) -> str | None:
    """Return why a dataset of this format may not have a column of this name in poses.csv yet, or None if it may."""
    if format != DATASET_FORMAT or not _POSE_COLUMNS.fullmatch(name):
        return None
    return f"{format} gives this column a meaning that this release does not support yet; remove or rename it"


def refuse_files(format: Any, names: Sequence[str]) -> list[Fault]:
    """Return a fault for every file that this format defines and that is not read yet."""
    if format != DATASET_FORMAT:
        return []
    message = f"{format} defines this file, and this release does not support it yet; remove it"
    return [Fault(name, message) for name in names if name in _FILES]
