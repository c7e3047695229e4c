"""Joint angles in another unit: degrees or grads where radians are expected, or angles that were converted from the wrong unit.

Degrees that were never converted are recognised by their size in most tables, when these are read; angles that were radians and were converted as if
they were degrees are small, and look like those of an arm that hardly moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_angles
from scalar.units import DEG

GRAD = 0.9 * DEG
# [rad] a joint that goes through more has its angles in degrees or grads: real wrists go through 900 degrees at most.
MOST_TURNS = 4 * np.pi


def angle_units(dataset: Dataset) -> Iterator[Alternative]:
    """Yield every alternative in which all joint angles are in another unit, or were converted from another one."""
    turning = ~dataset.robot.slides
    if not turning.any():
        return
    widest = float(np.ptp(dataset.q[:, turning], axis=0).max(initial=0.0))
    # An arm that hardly moves leaves no residual on planes, whatever was measured: there, degrees are read only if it still moves then.
    told = widest > MOST_TURNS or not dataset.planes
    for unit, factor in (("degrees", DEG), ("grads", GRAD)) if told else ():
        read = _scaled(
            dataset,
            factor,
            f"the joint angles are in {unit}, not in radians",
            f"with {unit} read",
            "write radians in poses.csv",
        )
        yield replace(read, motion=factor)
    if 0.0 < widest < MOST_TURNS * DEG:
        radians = _scaled(
            dataset,
            1.0 / DEG,
            "the joint angles were radians, converted as if they were degrees",
            f"with the angles multiplied by {1.0 / DEG:.4g}",
            "write radians in poses.csv (where 'scalar import' made it: unit: rad in the mapping of each joint)",
        )
        yield replace(radians, motion=1.0 / DEG)
    for unit, other, factor in (("grads", "degrees", GRAD / DEG), ("degrees", "grads", DEG / GRAD)):
        yield _scaled(
            dataset,
            factor,
            f"the joint angles were {unit}, converted as if they were {other}",
            f"with the angles multiplied by {factor:.4g}",
            "convert the angles anew and write radians in poses.csv",
        )


def _scaled(dataset: Dataset, factor: float, says: str, changed: str, remedy: str) -> Alternative:
    """Return the alternative in which the angles of all joints that turn are multiplied by a factor."""
    q = dataset.q * np.where(dataset.robot.slides, 1.0, factor)
    return with_angles(dataset, q, "angle_unit", "poses.csv", says, changed, remedy)
