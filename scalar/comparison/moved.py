"""By how far predicted positions move: root mean square and largest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.units import MM


@dataclass(frozen=True, eq=False)
class Moved:
    """By how far predicted positions move [m], over random poses, after the best fit of base and sensor.

    Attributes:
        rms: Root mean square.
        largest: Of all poses.
    """

    rms: float
    largest: float

    @classmethod
    def of(cls, moved: Array) -> Moved:
        """Return the size of displacements ``(K, 3)`` [m]."""
        lengths = np.linalg.norm(moved.reshape(-1, 3), axis=1)
        return cls(float(np.sqrt(np.mean(lengths**2))), float(lengths.max()))

    def to_mapping(self) -> dict[str, float]:
        """Return both in millimetres."""
        return {"rms_mm": self.rms / MM, "largest_mm": self.largest / MM}
