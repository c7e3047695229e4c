"""The ranges of the joints over the poses of a calibration, and which other poses lie clearly outside of them.

What a model lacks outside of these ranges, no measurement shows. Corrections found within them may even do harm there: a compliance found on a robot
over 15 degrees of its second joint, for example, raised the error at other poses from 0.1 mm to 0.3 mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array

MEASURED_RANGES = "measured_ranges"
"""The key of a calibration's summary: ``[[lowest, highest], ...]`` of each joint [rad; m of a joint that slides]."""
_MARGIN = 0.1  # chosen: of a joint's range; what lies nearer to it than this counts as within


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
    margin = _MARGIN * np.ptp(ranges, axis=1)
    return (q < ranges[:, 0] - margin) | (q > ranges[:, 1] + margin)
