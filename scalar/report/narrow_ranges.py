"""The report's sentence on joints that were measured over a small part of their limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.report.lead_in import SMALL_RANGES
from scalar.report.words import listed
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# A joint is named if its measured range is a smaller part of the range between its limits. The value is a choice.
_SMALL_PART = 0.25


def narrow_ranges(dataset: Dataset) -> list[str]:
    """Return one sentence that names the joints with a narrow measured range, none if there are none.

    Nothing in the data shows what such a joint lacks elsewhere, and no stated error contains it.

    Args:
        dataset: The measured poses.
    """
    robot = dataset.robot
    measured, whole = np.ptp(dataset.q, axis=0), np.ptp(robot.limits, axis=1)
    joints = np.flatnonzero(measured < _SMALL_PART * whole)
    if not len(joints):
        return []
    parts = [
        f"joint {j + 1} over {measured[j] / size:.0f} of {whole[j] / size:.0f} {unit}"
        for j in joints
        for unit, size in [("mm", MM) if j in robot.prismatic else ("degrees", DEG)]
    ]
    ranges = "this range" if len(joints) == 1 else "these ranges"
    return [
        f"{SMALL_RANGES}: {listed(parts)}. What the model lacks outside {ranges}, such as a gear error, these data "
        "cannot show, and no error that is stated contains it."
    ]
