"""Which target plane each scan lies on, by its distances from the planes as fitted with the nominal arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.units import MM

FARTHEST = 150 * MM
"""Largest distance of a scan from its plane, however badly the nominal arm fits. Chosen."""
# A scan that is nearer may lie on its plane, however well the others fit: the nominal arm errs more in some poses.
_NEAREST = 30 * MM
# Multiple of the median distance: a scan that is farther from every plane lies on another surface.
_TIMES_USUAL = 5.0
_CLEARLY = 2.0  # a scan's plane is clear if every other plane is more than this many times farther away


@dataclass(frozen=True, eq=False)
class Labels:
    """The planes of S scans.

    Attributes:
        index: ``(S,)``, the index of the plane; -1 where none is near, or two are.
        nearest: ``(S,)`` [m], root mean square distance of the scan from the nearest plane.
    """

    index: Array
    nearest: Array

    @property
    def count(self) -> int:
        """Return how many scans lie on a plane."""
        return int(np.count_nonzero(self.index >= 0))

    @property
    def typical(self) -> float:
        """Return the median distance from the nearest plane [m]; infinite without scans."""
        return float(np.median(self.nearest)) if len(self.nearest) else np.inf


def labels_by(distances: Array) -> Labels:
    """Return which plane each scan lies on, by root mean square distances ``(S, K)`` [m]."""
    order = np.sort(distances, axis=1)
    nearest = order[:, 0]
    if not len(nearest):
        return Labels(np.zeros(0, dtype=int), nearest)
    limit = min(FARTHEST, max(_NEAREST, _TIMES_USUAL * float(np.median(nearest))))
    clear = nearest < limit
    if order.shape[1] > 1:
        clear &= order[:, 1] > _CLEARLY * nearest
    return Labels(np.where(clear, np.argmin(distances, axis=1), -1), nearest)
