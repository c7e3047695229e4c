"""A sliding joint whose column stands before or behind those of all others, as controllers record a rail (E1, EXT1), and not at its own place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_angles
from scalar.geometry.se3 import Array


def displaced_slides(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the travel of a joint that slides was written into the first or the last column of the joints.

    Args:
        dataset: The measurements as described.
    """
    n = dataset.robot.n_joints
    for slide in dataset.robot.prismatic:
        for place in {0, n - 1} - {slide}:
            end = "first" if place == 0 else "last"
            others = f"q{slide + 2} to q{n}" if place else f"q1 to q{slide}"
            yield replace(
                with_angles(dataset, put_back(dataset.q, place, slide)),
                what="swapped_joints",
                where=f"joint {slide + 1}",
                file="poses.csv",
                says=f"the travel of joint {slide + 1} stands in the {end} column, q{place + 1} of poses.csv, and other joints beside their columns",
                changed=f"with it in the column q{slide + 1}",
                remedy=f"write the travel into q{slide + 1}, and the other joints in their order into {others}; where 'scalar import' made it, "
                "correct the columns in the mapping, and import again",
            )


def put_back(q: Array, place: int, slide: int) -> Array:
    """Return joint positions ``(N, n)`` with the column at one place moved to another, both from 0, the others keeping their order."""
    return np.insert(np.delete(q, place, axis=1), slide, q[:, place], axis=1)
