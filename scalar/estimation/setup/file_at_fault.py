"""Which file of a dataset a suspected error of the set-up stands in, so that the message begins with the file that has to be corrected."""

from __future__ import annotations

_FILES = {
    "swapped_joints": "poses.csv",
    "swapped_planes": "poses.csv",
    "coupled_joints": "poses.csv",
    "lost_row": "poses.csv",
    "moved_target": "poses.csv",
    "exchanged_target": "points.csv",
    "exchanged_columns": "points.csv",
}
"""By the kind of the error; ``where`` states the file of others, and errors that remain are those of the description."""


def file_at_fault(what: str, where: str) -> str:
    """Return the name of the file that has to be corrected.

    Args:
        what: The kind of the error, as in ``Alternative``.
        where: What it concerns; the name of a file, or a part of dataset.yaml in words.
    """
    return _FILES.get(what, where if where.endswith(".csv") else "dataset.yaml")
