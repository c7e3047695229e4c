"""Recorded directions of approach that are the opposite of the moves between the poses, as where 1 and -1 were taken the wrong way round."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.moves import side_column

# Of all joints together; fewer may be opposite because the program went there by way of other poses.
_LEAST_MOVES = 20
# Share of the moves, chosen: a program that goes by way of other poses does not reverse all of them.
_OPPOSITE = 0.95


def opposite_approach(dataset: Dataset) -> str:
    """Return a sentence if the directions of approach are the opposite of the moves from pose to pose; empty if they are not, or none are recorded.

    Args:
        dataset: What was measured, its poses in the order of acquisition.
    """
    # Looked for in the table: the known poses would compute all moves to look for it.
    if "approach1" not in dataset.poses:
        return ""
    recorded = dataset.known_poses.approach()
    if recorded is None:
        return ""
    columns = dataset.known_poses.columns
    moved = np.column_stack([columns[side_column(j + 1)] for j in range(dataset.robot.n_joints)])
    told = (moved != 0.0) & (recorded != 0.0)
    if told.sum() < _LEAST_MOVES:
        return ""
    opposite = float(np.mean(np.sign(recorded[told]) != moved[told]))
    if opposite < _OPPOSITE:
        return ""
    return (
        f"the columns approach1 to approach{dataset.robot.n_joints} are the opposite of {100 * opposite:.0f} % of the moves from pose to pose: they "
        "have to be 1 where a joint arrived with a growing position, and -1 where with a falling one; exchange the two if they stand for something "
        "else, or state the order in which the poses were measured"
    )
