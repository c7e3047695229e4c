"""Numbers that stand for "not measured", such as -999 in every column, where nothing said that they do."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Fault, InvalidInput
from scalar.estimation.pose_consistency import places_returned_to
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

_LEAST_ROWS = 2  # with the same number in all columns: of true places not even one has it
_MOST_NAMED = 8


def refuse_placeholders(dataset: Dataset) -> None:
    """Refuse points whose coordinates are all one number, the same at several poses; do nothing if there are none.

    Args:
        dataset: Of a tracker. Where a target returns to stated places, one of these may be the origin.

    Raises:
        InvalidInput: There are such points.
    """
    rows = placeholders(dataset)
    if not len(rows):
        return
    pose = dataset.pose_of_point
    ids = [str(dataset.pose_ids[i]) for i in dict.fromkeys(pose[rows])]
    more = f" and {len(ids) - _MOST_NAMED} more" if len(ids) > _MOST_NAMED else ""
    number = f"{dataset.points[rows[0], 0]:g}"
    raise InvalidInput(
        [
            Fault(
                kind_of(dataset).format.measured_in,
                f"x, y and z are all {number} [m] at poses {', '.join(ids[:_MOST_NAMED])}{more}: probably what the instrument writes where it sees "
                "no target; remove these rows, or, where 'scalar import' made the table, name the number in the mapping as the file writes it "
                "(text: {missing: [...]}), with drop_without: [x]",
                None,
                "x,y,z",
            )
        ]
    )


def placeholders(dataset: Dataset) -> Array:
    """Return the numbers ``(k,)`` of the points of which all coordinates are one number that others have as well; none for other sensors."""
    none = np.empty(0, dtype=int)
    if not kind_of(dataset).measures_positions:
        return none
    alike = np.flatnonzero(np.all(dataset.points == dataset.points[:, :1], axis=1))
    if len(alike) < _LEAST_ROWS or places_returned_to(dataset).any():
        return none
    values, counts = np.unique(dataset.points[alike, 0], return_counts=True)
    most = values[np.argmax(counts)]
    return alike[dataset.points[alike, 0] == most] if counts.max() >= _LEAST_ROWS else none
