"""Which columns of poses.csv are covariates: numeric columns to which the format gives no meaning of its own."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.formats import COMMANDED, TARGET_MOTION
from scalar.data.moves import move_columns

KNOWN_POSE_COLUMNS = ("pose", "plane", "order", "time", "temperature", "session")


def covariate_names(columns: Sequence[str], n_joints: int) -> tuple[str, ...]:
    """Return the names of the covariates among the columns of a table of poses, in the order of the columns.

    The columns ``qc1..qcn`` are commanded joint positions only if there is one for each joint; otherwise they are covariates as well.
    """
    joints = range(1, n_joints + 1)
    known = {*KNOWN_POSE_COLUMNS, *(f"{stem}{i}" for stem in ("q", "approach") for i in joints)}
    known |= {*move_columns(n_joints), *TARGET_MOTION}
    commanded = {f"{COMMANDED}{i}" for i in joints}
    known |= commanded if commanded <= {*columns} else set()
    return tuple(str(name) for name in columns if name not in known)
