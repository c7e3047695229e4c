"""A reading that an instrument repeats: it did not see the target at a pose, and the reading of the pose before was written once more."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.acquisition import order_and_time
from scalar.units import MM

# Least distance of the flange between two poses: a target that stays in its place meanwhile was probably not seen.
_LEAST_MOVED = 20 * MM
_STAYS = 0.02  # of that distance: so little does the reading change


def reading_repeated(dataset: Dataset, row: int) -> str:
    """Return the clause of a sentence on a pose that says which pose's reading it repeats; empty for most poses.

    The readings of a tracker scatter, so that a repeated one need not be the same to the last digit.

    Args:
        dataset: Of a tracker with a reading at each pose; any other has no such clause.
        row: Of the pose, which contradicts the others.
    """
    if dataset.planes or np.any(np.diff(dataset.starts) != 1):
        return ""
    in_order = np.argsort(order_and_time(dataset)[0], kind="stable")
    at = int(np.flatnonzero(in_order == row)[0])
    if at == 0:
        return ""
    before = int(in_order[at - 1])
    if dataset.session is not None and dataset.session[before] != dataset.session[row]:
        return ""
    moved, read = (
        float(np.linalg.norm(places[1] - places[0]))
        for places in (
            dataset.robot.flange(dataset.q[[before, row]])[:, :3, 3],
            dataset.points[[before, row], :3],
        )
    )
    if moved < _LEAST_MOVED or read > _STAYS * moved:
        return ""
    alike = (
        f"that of pose {dataset.pose_ids[before]} to {read / MM:.2g} mm"
        if read
        else f"exactly that of pose {dataset.pose_ids[before]}"
    )
    return (
        f", and its reading is {alike}, although the flange moved by {moved / MM:.0f} mm "
        "between the two: the instrument probably did not see the target"
    )
