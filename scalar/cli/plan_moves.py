"""How far the joints move in a planned program, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.geometry.se3 import Array


def moved(q: Array, prismatic: Sequence[int]) -> str:
    """Return in words how far the joints move over the poses ``(k, n)`` [rad, m]: the sum over all moves of the joint that moves farthest."""
    import numpy as np

    steps = np.abs(np.diff(q, axis=0))
    slides = np.isin(np.arange(q.shape[1]), list(prismatic))
    parts = []
    for part, size, what in ((steps[:, ~slides], DEG, "deg"), (steps[:, slides], MM, "mm")):
        if part.shape[1]:
            total = float(part.max(axis=1).sum() / size)
            parts.append(
                f"{total:.0f} {what} of the farthest joint in all, {total / max(len(part), 1):.0f} {what} each"
            )
    return "; ".join(parts)
