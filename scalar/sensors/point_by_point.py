"""Kinds of sensor whose residual is prediction minus measurement, ``f = h(T_base_sensor, target) - y``, with a few rows for each pose."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.protocol import Measurement
from scalar.sensors.rows import Rows
from scalar.sensors.target import Target


class PointByPoint(Measurement):
    """A measurement of m numbers at each pose, all with the same noise.

    Attributes:
        values: ``(N, m)`` [m], what was measured.
    """

    values: Array

    @abstractmethod
    def predicted(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return what the sensor would measure without error, and its derivatives.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: What is measured.
            index: ``(N,)``, which item of the target each pose measures.

        Returns:
            Values ``(N, m)`` [m], their wrenches ``(N, m, 6)`` and derivatives by the coordinates of the target's item ``(N, m, t)``.
        """

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return how many numbers are measured at a pose."""
        return self.values.shape[1]

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``(h - y) / sigma`` and its derivatives."""
        if point_effects:
            raise NotImplementedError(f"effects on points do not act on a {self.words}")
        predicted, wrench, by_target = self.predicted(T_base_sensor, target, self.target_index)
        residual = predicted - self.values
        scale = 1.0 / self.sigma
        return Rows(residual * scale, wrench * scale, by_target * scale, np.zeros((*residual.shape, 0)))

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each pose the squared distance between model and measurement [m^2], and 1 for the number of residuals."""
        residual = self.rows(T_base_sensor, target, point_effects).residual * self.sigma
        return np.sum(residual**2, axis=1), np.ones(len(residual), dtype=int)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the derivatives of the prediction: every pose can be measured."""
        _, wrench, by_target = self.predicted(T_base_sensor, target, index)
        return wrench, by_target, np.ones(len(wrench), dtype=bool)
