"""A touch probe: one point a pose, the origin of the sensor, lies on a plate: ``f = n . o - d``.

It brings no metric of its own: scaled with the whole cell, a plane is still a plane. And it cannot see its own rotation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.geometry.planes import PARAMETERS_PER_PLANE, Planes
from scalar.geometry.se3 import Array, cross
from scalar.sensors.line_laser import fit_planes, plane_targets
from scalar.sensors.measurement import Measurement, Rows, Target, stated_sigma

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_IN_CONTACT = 1e-11  # m


@dataclass(frozen=True, eq=False)
class Probe(Measurement):
    """The contacts of a dataset."""

    target_index: Array
    sigma: float
    sigma_stated: bool

    rows_per_pose = 1
    equations_per_pose = 1
    sees_sensor_rotation = False
    has_metric = False
    contact_iterations = 12

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Probe:
        """Return the contacts of a dataset."""
        noise = dataset.sensor.noise
        return cls(plane_targets(dataset)[0], stated_sigma(noise), noise is not None)

    def initial_target(self, dataset: Dataset) -> Planes:
        """Return the planes at their rough guesses, one for each plane and session that occur."""
        return plane_targets(dataset)[1]

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Planes:
        """Return the planes of least squared distance to the contacts."""
        assert isinstance(target, Planes)
        o = T_base_sensor[:, :3, 3]
        return fit_planes(target, self.target_index, np.ones(len(o)), o, o[:, :, None] * o[:, None, :])

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``(n . o - d) / sigma`` and its derivatives."""
        assert isinstance(target, Planes)
        k, o = self.target_index, T_base_sensor[:, :3, 3]
        residual, wrench, by_target = contact(o, target, k)
        extra = np.zeros((len(o), 1, 0))
        if point_effects:
            columns = [
                effect.contact_columns(T_base_sensor, target, k, residual[:, None])
                for effect in point_effects
            ]
            extra = np.concatenate([column[:, :1] for column in columns], axis=2)
            residual = residual + extra[:, 0] @ np.concatenate(
                [effect.coefficients for effect in point_effects]
            )
        scale = 1.0 / self.sigma
        return Rows(
            residual[:, None] * scale, wrench[:, None] * scale, by_target[:, None] * scale, extra * scale
        )

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the rows of contacts, and which poses are in contact."""
        assert isinstance(target, Planes)
        residual, wrench, by_target = contact(T_base_sensor[:, :3, 3], target, index)
        return wrench[:, None], by_target[:, None], np.abs(residual) < _IN_CONTACT

    def contact_step(self, T_base_sensor: Array, target: Target, index: Array, by_angle: Array) -> Array:
        """Return the shortest step of the joints that closes the gap to first order, at most a fifth of a radian."""
        assert isinstance(target, Planes)
        residual, wrench, _ = contact(T_base_sensor[:, :3, 3], target, index)
        slope = np.einsum("ni,nij->nj", wrench, by_angle)
        step = -residual[:, None] * slope / np.maximum(np.sum(slope**2, axis=1, keepdims=True), 1e-12)
        return step * np.minimum(1.0, 0.2 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))

    def reweighted(self, T_base_sensor: Array, target: Target) -> Probe:
        """Return the same contacts: a contact's error is taken along the normal."""
        return self

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return per pose the squared distance to the plate [m^2] and one."""
        residual = self.rows(T_base_sensor, target, point_effects).residual[:, 0] * self.sigma
        return residual**2, np.ones(len(residual), dtype=int)


def contact(o: Array, planes: Planes, index: Array) -> tuple[Array, Array, Array]:
    """Return ``n . o - d`` ``(N,)`` [m], its wrench ``(N, 6)`` and its derivative by (u, v, d) of the plane ``(N, 3)``."""
    n = planes.normals[index]
    residual = np.sum(n * o, axis=1) - planes.distances[index]
    by_target = np.empty((len(o), PARAMETERS_PER_PLANE))
    by_target[:, :2] = np.einsum("nx,nxt->nt", o, planes.normal_derivatives[index])
    by_target[:, 2] = -1.0
    return residual, np.concatenate([cross(o, n), n], axis=1), by_target
