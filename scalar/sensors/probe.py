"""A touch probe: at each pose one point, the origin o of the sensor, lies on a plane with normal n and distance d: ``f = n . o - d``.

A probe measures no length: planes remain planes if the whole workcell is scaled. Nor does it observe its own rotation on the flange.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.sensor_formats import SensorFormat
from scalar.geometry.planes import PARAMETERS_PER_PLANE, Planes
from scalar.geometry.se3 import Array, cross
from scalar.sensors.plane_targets import OnPlanes, fit_planes, plane_targets
from scalar.sensors.point_by_point import PointByPoint
from scalar.sensors.pose_noise import NoiseComponent
from scalar.sensors.protocol import Measurement
from scalar.sensors.residual_noise import estimated_position_noise, noise_factor, scaled_up
from scalar.sensors.rows import LEAST_SIGMA, Pieces, Rows, UsualNoise, stated_sigma
from scalar.sensors.target import Target

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_IN_CONTACT = 1e-11  # m, largest height over the plane that counts as contact


@dataclass(frozen=True, eq=False)
class Probe(OnPlanes, PointByPoint):
    """The contacts of a dataset, ``values`` being their heights over the planes ``(N, 1)`` [m], which are all zero.

    Attributes:
        stated: The stated noise [m], or None.
        unknowns: Approximate number of parameters that a fit estimates.
        fixed: Whether the noise was estimated before and is not estimated again.
    """

    values: Array
    target_index: Array
    sigma: float
    sigma_stated: bool
    stated: float | None = None
    unknowns: int = 0
    fixed: bool = False

    format = SensorFormat("probe", on_planes=True, needs_nominal_pose=True, table=None)
    words = "touch probe"
    on_flange = "tip of the probe", Measurement.on_flange[1]
    residual_words = "height of a contact over its plane"
    usual_noise = UsualNoise("a touch probe repeats to 0.01 mm or better", 1e-4)
    carries_scale = False
    contact_iterations = 12

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Probe:
        """Return the contacts of a dataset."""
        noise = dataset.sensor.noise
        index, planes = plane_targets(dataset)
        unknowns = 4 * dataset.robot.n_joints + 3 + PARAMETERS_PER_PLANE * len(planes.names)
        heights = np.zeros((len(index), 1))
        return cls(heights, index, stated_sigma(noise), noise is not None, noise, unknowns)

    def reweighted(self, T_base_sensor: Array, target: Target) -> Probe:
        """Return the same contacts with a noise that is not stated, or stated too large, estimated from their heights over the planes."""
        if self.fixed:
            return self
        N = len(self.target_index)
        heights = self.predicted(T_base_sensor, target, self.target_index)[0]
        rms = scaled_up(float(np.sqrt(np.mean(heights**2))) / self.sigma, N, self.unknowns)
        factor = noise_factor(rms, N, self.unknowns, stated=self.sigma_stated)
        if factor == 1.0:
            return self
        return replace(self, sigma=max(self.sigma * factor, LEAST_SIGMA), sigma_stated=False)

    def counting(self, coefficients: int) -> Probe:
        """Return the same contacts, with coefficients of effects counted among the parameters when the noise is estimated."""
        return replace(self, unknowns=self.unknowns + coefficients)

    def weighted_like(self, other: Measurement) -> Probe:
        """Return the same contacts with the noise of another measurement of the same poses; it is not estimated again."""
        return replace(self, sigma=other.sigma, sigma_stated=other.sigma_stated, fixed=True)

    @property
    def ratio_to_stated(self) -> float | None:
        """Return the noise over the stated one; None if none was stated."""
        return None if self.stated is None else self.sigma / stated_sigma(self.stated)

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the noise of the contacts if it is estimated."""
        if self.sigma_stated or self.sigma == stated_sigma(self.stated):
            return ()
        return (estimated_position_noise(self.sigma, len(self.target_index), self.stated),)

    @property
    def contact_factors(self) -> Array:
        """Return the factors of ``n . o - d``, one row for each contact, in standard deviations."""
        return np.broadcast_to([1.0 / self.sigma, 0.0, 0.0], (len(self.target_index), 1, 3))

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Planes:
        """Return the planes of least squared distance to the contacts."""
        assert isinstance(target, Planes)
        o = T_base_sensor[:, :3, 3]
        return fit_planes(target, self.target_index, np.ones(len(o)), o, o[:, :, None] * o[:, None, :])

    def predicted(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return ``n . o - d`` ``(N, 1)`` [m], its wrench and its derivative by (u, v, d) of the plane."""
        assert isinstance(target, Planes)
        o, n = T_base_sensor[:, :3, 3], target.normals[index]
        height = np.sum(n * o, axis=1) - target.distances[index]
        by_target = np.empty((len(o), PARAMETERS_PER_PLANE))
        by_target[:, :2] = np.einsum("nx,nxt->nt", o, target.normal_derivatives[index])
        by_target[:, 2] = -1.0
        wrench = np.concatenate([cross(o, n), n], axis=1)
        return height[:, None], wrench[:, None], by_target[:, None]

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``(n . o - d) / sigma`` and its derivatives; effects on planes add their height at the sensor's origin."""
        rows = super().rows(T_base_sensor, target)
        if not point_effects:
            return rows
        height = rows.residual * self.sigma
        extra = np.concatenate(
            [
                e.contact_columns(T_base_sensor, target, self.target_index, height)[:, :1]
                for e in point_effects
            ],
            axis=2,
        )
        added = extra @ np.concatenate([effect.coefficients for effect in point_effects])
        return Rows((height + added) / self.sigma, rows.wrench, rows.target, extra / self.sigma)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the rows of contacts, and which poses are in contact."""
        height, wrench, by_target = self.predicted(T_base_sensor, target, index)
        return wrench, by_target, np.abs(height[:, 0]) < _IN_CONTACT

    def contact_step(self, T_base_sensor: Array, target: Target, index: Array, by_angle: Array) -> Array:
        """Return the shortest step of the joints ``(N, n)`` [rad] that brings the probe to its plane to first order, at most 0.2 rad long."""
        height, wrench, _ = self.predicted(T_base_sensor, target, index)
        slope = np.einsum("nmi,nij->nj", wrench, by_angle)
        step = -height * slope / np.maximum(np.sum(slope**2, axis=1, keepdims=True), 1e-12)
        return step * np.minimum(1.0, 0.2 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))

    def shift(self, predicted: Array, residual: Array) -> tuple[Array, Array, Array]:
        """Return each contact's height [m] by a prediction and by the residual, and its standard error, ``(N,)`` each."""
        sigma = np.full(len(residual), self.sigma)
        return predicted[:, 0] * sigma, residual[:, 0] * sigma, sigma

    def shown_residual(self, residual: Array) -> Array:
        """Return the height of each contact over its plane ``(N,)`` [m]."""
        return residual[:, 0] * self.sigma

    def pieces(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any], effect: Any
    ) -> Pieces:
        """Return the contacts, each as one piece."""
        N = len(T_base_sensor)
        height = self.rows(T_base_sensor, target, point_effects).residual[:, 0] * self.sigma
        columns = effect.contact_columns(T_base_sensor, target, self.target_index, np.zeros((N, 1)))[:, 0]
        sigma = np.full(N, self.sigma)
        place = T_base_sensor[:, :3, 3]
        return Pieces(
            np.arange(N),
            np.zeros(N),
            place,
            height,
            columns @ effect.coefficients,
            np.ones(N),
            sigma,
            np.zeros((0, 2)),
        )
