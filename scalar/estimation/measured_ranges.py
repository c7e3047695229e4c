"""The ranges of the joints, and of what else effects follow, over the poses of a calibration, and which other poses lie clearly outside of them.

What a model lacks outside of these ranges, no measurement shows. Corrections found within them may even do harm there: a compliance found on a robot
over 15 degrees of its second joint, for example, raised the error at other poses from 0.1 mm to 0.3 mm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.poses import is_joint
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects import Effect

MEASURED_RANGES = "measured_ranges"
"""The key of a calibration's summary: ``[[lowest, highest], ...]`` of each joint [rad; m of a joint that slides]."""
MEASURED_COLUMNS = "measured_columns"
"""The key of a calibration's summary: ``{column: [lowest, highest]}`` of the columns of poses.csv that its effects follow."""
_MARGIN = 0.1  # chosen: of a joint's range; what lies nearer to it than this counts as within


def ranges_of_columns(dataset: Dataset, effects: Sequence[Effect]) -> dict[str, list[float]]:
    """Return the range of each column of poses.csv, other than joints and order, that effects follow or vary with: a temperature, for example."""
    columns = dict.fromkeys(name for effect in effects for name in (*effect.follows, *effect.depends_on))
    names = [name for name in columns if name in dataset.poses and name != "order" and not is_joint(name)]
    values = {name: dataset.poses[name].to_numpy(dtype=float) for name in names}
    return {name: [float(of_poses.min()), float(of_poses.max())] for name, of_poses in values.items()}


def measured_columns(summary: Mapping[str, Any]) -> dict[str, Array]:
    """Return the range ``(2,)`` of each column that the effects of a calibration follow; none if an earlier release wrote the file.

    Args:
        summary: Of the calibration.
    """
    return {name: np.array(limits, dtype=float) for name, limits in summary.get(MEASURED_COLUMNS, {}).items()}


def measured_ranges(summary: Mapping[str, Any]) -> Array | None:
    """Return the ranges of the joints ``(n, 2)`` [rad; m] over the measured poses; None if an earlier release wrote the file.

    Args:
        summary: Of the calibration.
    """
    ranges = summary.get(MEASURED_RANGES)
    return np.array(ranges, dtype=float) if ranges else None


def clearly_outside(ranges: Array, q: Array) -> Array:
    """Return which joint positions lie outside of ranges by more than a tenth of each ``(N, n)`` bool.

    Args:
        ranges: ``(n, 2)`` [rad; m].
        q: ``(N, n)`` [rad; m].
    """
    low, high = widened(ranges).T
    return (q < low) | (q > high)


def widened(ranges: Array) -> Array:
    """Return ranges ``(n, 2)`` [rad; m], each with a tenth of it added at both ends: what lies beyond is clearly outside."""
    margin = _MARGIN * np.ptp(ranges, axis=1)
    return np.column_stack([ranges[:, 0] - margin, ranges[:, 1] + margin])
