"""A target whose position is known, so that it has no parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class FixedTarget:
    """Points with known positions.

    Attributes:
        points: ``(K, 3)`` [m], base frame.
    """

    points: Array

    @classmethod
    def at(cls, points: Sequence[Sequence[float]] | Array) -> FixedTarget:
        """Return the target of points ``(K, 3)`` [m]."""
        return cls(np.asarray(points, dtype=float).reshape(-1, 3))

    @property
    def parameter_names(self) -> list[str]:
        """Return no name."""
        return []

    @property
    def parameter_units(self) -> list[str]:
        """Return no unit."""
        return []

    @property
    def vector(self) -> Array:
        """Return no coordinate, ``(0,)``."""
        return np.zeros(0)

    def with_vector(self, vector: Array) -> FixedTarget:
        """Return the same target."""
        return self

    def rebased(self) -> FixedTarget:
        """Return the same target."""
        return self

    def expressed_about(self, guess: FixedTarget) -> FixedTarget:
        """Return the same target."""
        return self
