"""True scans of one scene, for reuse by other scenes with the same workcell and postures.

The frames of the sensor and the ranges of its rays depend neither on the noise nor on the declared model. So a sweep
casts its rays once for each seed; a scene with fewer poses or points takes a subset of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.simulation.transforms import Array


@dataclass(frozen=True, eq=False)
class Scans:
    """True frames and ranges, without noise and without effects.

    Attributes:
        workcell: what they depend on, as text.
        T_base_sensor: for each plane (k, 4, 4), in the order of the plan.
        angles: for each plane (k, M) [rad], angles of the rays, rising.
        ranges: for each plane (k, M) [m].
    """

    workcell: str
    T_base_sensor: tuple[Array, ...]
    angles: tuple[Array, ...]
    ranges: tuple[Array, ...]

    def at(self, wanted: Sequence[int], order: Array, chosen: Array) -> tuple[Array, Array] | None:
        """Return T_base_sensor (N, 4, 4) and ranges (N, m) [m] of a scene, None where a ray was not cast.

        Args:
            wanted: number of poses of each plane.
            order: (N,), acquisition order of poses listed plane by plane.
            chosen: (N, m) [rad], angles of the rays in that order, rising.
        """
        if any(len(T) < k for T, k in zip(self.T_base_sensor, wanted, strict=True)):
            return None

        def listed(tables: tuple[Array, ...]) -> Array:
            return np.concatenate([table[:k] for table, k in zip(tables, wanted, strict=True)])[order]

        angles, ranges = listed(self.angles), listed(self.ranges)
        place = np.array([np.searchsorted(row, asked) for row, asked in zip(angles, chosen, strict=True)])
        place = np.minimum(place, angles.shape[1] - 1)
        if not np.array_equal(np.take_along_axis(angles, place, axis=1), chosen):
            return None
        return listed(self.T_base_sensor), np.take_along_axis(ranges, place, axis=1)
