"""Add the number of a pose to texts that name its order of acquisition: an effect that begins during a campaign knows the order alone."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_MOMENT = re.compile(r"\b(?:the pose of|(from|from about|near)) order (\d+)\b")


def with_pose_numbers(text: str, dataset: Dataset) -> str:
    """Return a text that names the number of the pose wherever it names an order from which on, or near which, something changed.

    ``from order 61 on`` becomes ``from pose 75 (order 61) on``, and ``the pose of order 61`` becomes ``pose 75 (order 61)``.

    Args:
        text: Plain text, or a page.
        dataset: The poses as they were read, with the order of acquisition.
    """
    order = dataset.known_poses.order
    rows = np.argsort(order, kind="stable")
    whole = np.round(order[rows])  # as texts write it

    def named(found: re.Match[str]) -> str:
        number = float(found[2])
        # If no pose has this order, the change is seen from the next one on.
        first, after = np.searchsorted(whole, number), np.searchsorted(whole, number, "right")
        if after > first + 1 or first == len(rows):
            return found[0]
        pose = dataset.pose_ids[rows[first]]
        return f"{found[1] + ' ' if found[1] else ''}pose {pose} (order {found[2]})"

    return _MOMENT.sub(named, text)
