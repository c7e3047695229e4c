"""Which columns of poses.csv are covariates: numeric columns to which the format gives no meaning of its own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from scalar.data.formats import COMMANDED, PAYLOAD, TARGET_MOTION, TORQUE
from scalar.data.located_table import closest
from scalar.data.moves import move_columns

_ALIKE = 0.8  # similarity of names from which one may be meant for the other: aproach and approach have 0.93
_SHORT = 5  # letters: names that are no longer resemble many words
_BY_JOINT = ("approach", COMMANDED, TORQUE)
_OF_POSES = ("order", "time", "temperature", "session", PAYLOAD[0])
KNOWN_POSE_COLUMNS = ("pose", "plane", "order", "time", "temperature", "session")


def covariate_names(columns: Sequence[str], n_joints: int) -> tuple[str, ...]:
    """Return the names of the covariates among the columns of a table of poses, in the order of the columns.

    The columns ``qc1..qcn`` are commanded joint positions only if there is one for each joint; otherwise they are covariates as well.
    """
    known = _defined(n_joints)
    commanded = {f"{COMMANDED}{i}" for i in range(1, n_joints + 1)}
    if commanded <= {*columns}:
        known |= commanded
    return tuple(str(name) for name in columns if name not in known)


@cache
def _defined(n_joints: int) -> frozenset[str]:
    """Return the columns to which the format gives a meaning, without the commanded positions."""
    by_joint = (f"{stem}{i}" for stem in ("q", "approach") for i in range(1, n_joints + 1))
    return frozenset({*KNOWN_POSE_COLUMNS, *by_joint, *move_columns(n_joints), *TARGET_MOTION})


def misspelt_columns(columns: Sequence[str], n_joints: int) -> list[str]:
    """Return a clause for each column of a table of poses whose name resembles one that the format knows and the table lacks.

    Columns that differ in their numbers alone are one clause.

    Args:
        columns: Names of all columns of the table.
        n_joints: Number of joints.
    """
    stems: dict[str, list[tuple[str, str]]] = {}
    for name in covariate_names(columns, n_joints):
        stem = name.rstrip("0123456789")
        number = name.removeprefix(stem)
        by_joint = number.isdecimal() and 1 <= int(number) <= n_joints
        meant = _resembled(stem.lower(), _BY_JOINT if by_joint else _OF_POSES)
        if meant and stem not in _BY_JOINT and (by_joint or not number) and f"{meant}{number}" not in columns:
            stems.setdefault(stem, []).append((name, f"{meant}{number}"))
    return [
        f"column {names[0][0]!r} is taken for a record of your own; if it is {names[0][1]!r}, rename it"
        + (f", and {', '.join(repr(name) for name, _ in names[1:])} likewise" if len(names) > 1 else "")
        for names in stems.values()
    ]


def _resembled(name: str, known: Sequence[str]) -> str:
    """Return the known name that a name resembles, or an empty text; short names have to be its beginning."""
    begun = [one for one in known if name.startswith(one)]
    return begun[0] if begun else closest(name, [one for one in known if len(one) > _SHORT], _ALIKE)
