"""How far the joints move in a planned program, in words, and the program in degrees."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scalar.units import DEG, MM, unit_of_joint

if TYPE_CHECKING:
    import pandas as pd

    from scalar.geometry.se3 import Array


def moves_in_words(q: Array, prismatic: Sequence[int]) -> str:
    """Return in words how far the joints move over the poses ``(k, n)`` [rad, m]: the sum over all moves of the joint that moves farthest."""
    import numpy as np

    steps = np.abs(np.diff(q, axis=0))
    slides = np.isin(np.arange(q.shape[1]), list(prismatic))
    parts = []
    for part, size, what in ((steps[:, ~slides], DEG, "deg"), (steps[:, slides], MM, "mm")):
        if part.shape[1]:
            total = float(part.max(axis=1).sum() / size)
            parts.append(
                f"{total / max(len(part), 1):.0f} {what} from pose to pose, {total:.0f} {what} in all, by the joint that moves farthest each time"
            )
    return "; ".join(parts)


def in_degrees(table: pd.DataFrame, prismatic: Sequence[int]) -> pd.DataFrame:
    """Return a table of poses [rad, m] with joint angles in degrees, and the travel of joints that slide (counted from 0) in millimetres."""
    names = [name for name in table.columns if name[0] == "q"]
    units = [unit_of_joint(i in prismatic) for i in range(len(names))]
    scaled = {name: table[name] / unit for name, (_, unit) in zip(names, units, strict=True)}
    heads = {name: f"{name}_{word}" for name, (word, _) in zip(names, units, strict=True)}
    return table.assign(**scaled).rename(columns=heads)
