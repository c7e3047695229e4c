"""Which columns of poses.csv are covariates: numeric columns to which the format gives no meaning of its own."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

from scalar.data.formats import COMMANDED, PAYLOAD, TARGET_MOTION, TORQUE
from scalar.data.moves import move_columns

_ALIKE = (
    0.8  # similarity of two names from which one may be meant for the other: payload_kg and payload have 0.82
)
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


def misspelt_columns(columns: Sequence[str], n_joints: int) -> list[str]:
    """Return a clause for each column of a table of poses whose name resembles one that the format knows and the table lacks.

    Columns that differ in their numbers alone are one clause.

    Args:
        columns: Names of all columns of the table.
        n_joints: Number of joints.
    """
    by_joint = [f"{stem}{i + 1}" for stem in ("approach", COMMANDED, TORQUE) for i in range(n_joints)]
    known = [*KNOWN_POSE_COLUMNS, *by_joint, *PAYLOAD]
    lacking = [name for name in known if name not in columns]
    alike: dict[str, list[tuple[str, str]]] = {}
    for name in covariate_names(columns, n_joints):
        close = get_close_matches(name.lower(), lacking, n=len(PAYLOAD), cutoff=_ALIKE)
        close.sort(
            key=lambda one: not name.lower().startswith(one)
        )  # payload_kg is a payload and not a payload_z
        if name not in known and close:
            alike.setdefault(name.rstrip("0123456789"), []).append((name, close[0]))
    return [
        f"column {names[0][0]!r} is taken for a record of your own; if it is {names[0][1]!r}, rename it"
        + (f", and so {len(names) - 1} more" if len(names) > 1 else "")
        for names in alike.values()
    ]
