"""A joint whose column stands before or behind those of all others: a rail that controllers record so (E1, EXT1), or joint 1 behind the last one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_angles
from scalar.geometry.se3 import Array


def displaced_slides(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the travel of a joint that slides was written into the first or the last column of the joints."""
    for slide in dataset.robot.prismatic:
        yield from _displaced(dataset, slide)


def displaced_ends(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the first joint was written into the last column, or the last into the first, and neither slides."""
    n = dataset.robot.n_joints
    for joint in (0, n - 1) if n > 2 else ():  # of two joints, the columns are exchanged
        if not dataset.robot.slides[joint]:
            yield from _displaced(dataset, joint)


def _displaced(dataset: Dataset, joint: int) -> Iterator[Alternative]:
    """Yield the alternatives in which a joint, from 0, was written into the first or the last column of the joints."""
    n, what = dataset.robot.n_joints, "travel" if dataset.robot.slides[joint] else "angle"
    for place in {0, n - 1} - {joint}:
        end = "first" if place == 0 else "last"
        others = f"q{joint + 2} to q{n}" if place else f"q1 to q{joint}"
        yield with_angles(
            dataset,
            put_back(dataset.q, place, joint),
            "swapped_joints",
            f"joint {joint + 1}",
            f"the {what} of joint {joint + 1} stands in the {end} column, q{place + 1} of poses.csv, and other joints beside their columns",
            f"with it in the column q{joint + 1}",
            f"write the {what} into q{joint + 1}, and the other joints in their order into {others}; where 'scalar import' made it, "
            "correct the columns in the mapping, and import again",
        )


def put_back(q: Array, place: int, slide: int) -> Array:
    """Return joint positions ``(N, n)`` with the column at one place moved to another, both from 0, the others keeping their order."""
    return np.insert(np.delete(q, place, axis=1), slide, q[:, place], axis=1)
