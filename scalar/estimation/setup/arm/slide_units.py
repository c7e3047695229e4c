"""The travel of a joint that slides in another unit than it is read in, as where a rail's centimetres were imported as millimetres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, with_angles
from scalar.estimation.setup.length_units import WITH_MILLIMETRES


def slide_units(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the travel of one joint that slides was in another unit than was stated.

    Args:
        dataset: The measurements as described.
    """
    for slide in dataset.robot.prismatic:
        if np.ptp(dataset.q[:, slide]) == 0.0:
            continue
        for was, stated, factor in _mistakes():
            q = dataset.q.copy()
            q[:, slide] *= factor
            size = f"{factor:.4g} times too small" if factor > 1 else f"{1 / factor:.4g} times too large"
            yield with_angles(
                dataset,
                q,
                "length_unit",
                f"joint {slide + 1}",
                f"the travel of joint {slide + 1}, which slides, is {size}, as {was} are that were taken for {stated}",
                f"with q{slide + 1} multiplied by {factor:.4g}",
                f"write q{slide + 1} in metres; where 'scalar import' made it, correct the unit of this joint in the mapping",
            )


def _mistakes() -> Iterator[tuple[str, str, float]]:
    """Yield pairs of units that may be mistaken for one another, and the factor by which numbers of the first, read as the second, are too small."""
    seen: list[float] = []
    for was, size in WITH_MILLIMETRES.items():
        for stated, other in WITH_MILLIMETRES.items():
            factor = size / other
            if was != stated and not np.any(np.isclose(factor, seen)):
                seen.append(factor)
                yield was, stated, factor
