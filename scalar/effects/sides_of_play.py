"""What determines on which side of its play a joint rests, and whether a dataset records it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.effects.acquisition import steps_are_known

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

SIDES = ("approach", "moves", "torque")
"""The recorded direction of approach, the last move by the order of the poses, or the sign of the gravity torque."""


def told_by(dataset: Dataset, joint: int) -> str:
    """Return what determines on which side of its play a joint rests: ``approach`` if it is recorded and varies, else ``torque``."""
    name = f"approach{joint}"
    recorded = name in dataset.poses and len(np.unique(dataset.poses[name].to_numpy())) > 1
    return "approach" if recorded else "torque"


def unknown_side(dataset: Dataset, joint: int, by: str) -> str | None:
    """Return why a word of a command line cannot determine on which side a joint rests, or None if it can."""
    if by not in SIDES:
        return f"'{by}' does not say what determines on which side of its play a joint rests: write one of {', '.join(SIDES)}"
    if by == "approach" and told_by(dataset, joint) != by:
        return f"poses.csv has no column approach{joint}, or one with a single value: the side from which joint {joint} came is not recorded"
    if by == "moves" and not steps_are_known(dataset):
        return f"the order of the poses does not show from which side joint {joint} came"
    if by == "torque" and dataset.robot.slides[joint - 1]:
        return f"joint {joint} slides, and no torque of gravity determines on which side of its play it rests"
    return None
