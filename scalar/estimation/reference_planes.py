"""Planes that the user declares known, with standard deviations: they determine the scale and the place of the base, as far as planes can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class ReferencePlanes:
    """Planes that the dataset declares known, and the residual rows that keep their tilt and distance near what is declared.

    Attributes:
        index: ``(k,)``, their indices among the K planes of the target.
        normals, distances: As declared, ``(k, 3)`` and ``(k,)`` [m].
        normal_std, distance_std: ``(k,)`` [rad] and [m]; infinite where not declared.
    """

    index: Array
    normals: Array
    distances: Array
    normal_std: Array
    distance_std: Array

    @classmethod
    def of(cls, dataset: Dataset, target: Any) -> ReferencePlanes | None:
        """Return the planes of a target that the dataset declares known, or None where there are none."""
        if not isinstance(target, Planes):
            return None
        by_name = {plane.name: plane for plane in dataset.planes}
        found = []
        for k, name in enumerate(target.names):
            # With several sessions, the target's planes are called name@session; each has what is declared of the plane.
            plane = by_name[name.split("@")[0] if name not in by_name else name]
            if plane.normal_std is not None or plane.distance_std is not None:
                found.append((k, plane))
        if not found:
            return None

        def column(values: Sequence[float | None]) -> Array:
            return np.array([np.inf if value is None else value for value in values])

        return cls(
            np.array([k for k, _ in found]),
            np.array([plane.normal for _, plane in found]),
            np.array([plane.distance for _, plane in found]),
            column([plane.normal_std for _, plane in found]),
            column([plane.distance_std for _, plane in found]),
        )

    def rows(self, planes: Planes) -> tuple[Array, Array]:
        """Return the rows ``(4 k,)``, in standard deviations, and their derivatives by the planes' coordinates ``(4 k, 3 K)``.

        First come the three components of each normal, then the distances. Rows of what is not declared are zero.
        """
        count = len(self.index)
        delta = (planes.normals[self.index] - self.normals) / self.normal_std[:, None]
        residual = np.concatenate(
            [delta.ravel(), (planes.distances[self.index] - self.distances) / self.distance_std]
        )
        jacobian = np.zeros((4 * count, len(planes.vector)))
        by_tangent = planes.normal_derivatives[self.index] / self.normal_std[:, None, None]
        for i, k in enumerate(self.index):
            jacobian[3 * i : 3 * i + 3, 3 * k : 3 * k + 2] = by_tangent[i]
            jacobian[3 * count + i, 3 * k + 2] = 1.0 / self.distance_std[i]
        return residual, jacobian
