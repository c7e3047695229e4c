"""A line scanner: points (x, 0, z) in its own plane, all of which lie on one target plane.

``f_i = n . (T_base_sensor p_i) - d = [1, x_i, z_i] . c`` with the contact vector ``c = (n.o - d, n.X, n.Z)``, X, Z and o the axes and
the origin of the sensor in the base frame. A scan of any length is compressed to the rows ``R c`` (``scalar.sensors.compression``), each
point weighted by ``1 / (sigma |n . e_i|)``, e_i the direction in which the scanner errs: along the ray, or along z.
The incidence ``n . e_i`` is that of the current estimate, and is held constant in the rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.geometry.planes import Planes, tangent_basis
from scalar.geometry.se3 import Array
from scalar.sensors.compression import compress
from scalar.sensors.linear_guess import guesses
from scalar.sensors.plane_targets import fit_planes, moments_in_base, plane_targets, scatter_in_base
from scalar.sensors.pose_noise import PoseNoise
from scalar.sensors.profile import (
    LINE_BASIS,
    PointFactors,
    contact,
    contact_vectors,
    effect_rows,
    line_factors,
    point_basis,
    profile_factors,
    robust_variance,
    scatter_within,
)
from scalar.sensors.rows import LEAST_SIGMA, Pieces, Rows, stated_sigma
from scalar.sensors.scan_noise import NoisyScans
from scalar.sensors.scan_pieces import cut_in_pieces
from scalar.sensors.target import Guess, Target

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class LineLaser(NoisyScans):
    """The scans of a dataset, compressed.

    Attributes:
        points: ``(P, 2)`` [m], x and z of every point.
        starts: ``(N + 1,)``, pose i owns ``points[starts[i]:starts[i + 1]]``.
        target_index: ``(N,)``, index of the target plane of each pose.
        error_axis: ``ray`` or ``z``.
        sigma, sigma_stated: Standard deviation of a point [m] along the error axis, and whether the dataset states it.
        basis_names: Names of the functions of a point that R keeps; the first three are those of a flat plane.
        weighted: R of weighted points; None while all points have equal weights.
        equal: The factors with equal weights of all points, ``R_metric``; copies of this object with other weights share them.
        profiled: Whether R holds the three rows of ``profiles`` for each scan, ``(N, 3, k)``, instead of triangular factors.
        noise: The noise within scans, for which the three rows are whitened; None if it is white and the same for all points.
    """

    points: Array
    starts: Array
    target_index: Array
    error_axis: str
    sigma: float
    sigma_stated: bool
    basis_names: tuple[str, ...]
    weighted: Array | None
    equal: PointFactors
    profiled: bool = False
    noise: PoseNoise | None = None

    format = SensorFormat(
        "line-laser",
        on_planes=True,
        needs_nominal_pose=False,
        # The largest coordinate allows for lidars.
        table=MeasuredTable("scans", {"x": "m", "z": "m"}, True, "laser point", largest=20.0),
    )
    words = "line laser"
    on_flange = "scanner", "an axis of the scans is mirrored or the last joint has another zero"
    residual_words = "mean height of a scan over its plane"
    observes_orientation = True
    scans = True
    measures_range = True
    needs_spanning_planes = True

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the number of rows to which a scan is compressed."""
        return 3 if self.profiled else len(self.basis_names)

    @property
    def R(self) -> Array:  # type: ignore[override]
        """Return whitened triangular factors ``(N, k, k)``, or the rows of ``profiles`` ``(N, 3, k)``."""
        return self._equal_whitened if self.weighted is None else self.weighted

    @cached_property
    def _equal_whitened(self) -> Array:
        return self.R_metric / self.sigma

    @property
    def R_metric(self) -> Array:  # type: ignore[override]
        """Return triangular factors in metres ``(N, k, k)``, with equal weights of all points."""
        return self.equal.factors

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> LineLaser:
        """Return the scans of a dataset with equal weights of all points."""
        names = LINE_BASIS + tuple(name for name in dict.fromkeys(extra_basis) if name not in LINE_BASIS)
        return cls(
            points=dataset.points,
            starts=dataset.starts,
            target_index=plane_targets(dataset)[0],
            error_axis=dataset.sensor.error_axis,
            sigma=stated_sigma(dataset.sensor.noise),
            sigma_stated=dataset.sensor.noise is not None,
            basis_names=names,
            weighted=None,
            equal=PointFactors(names, dataset.points, dataset.starts, dataset.sensor.error_axis),
        )

    def first_guesses(
        self, T_base_flange: Array, target: Target, gravity: Array, thorough: bool
    ) -> list[Guess]:
        """Return the linear guesses of the scanner's pose (``scalar.sensors.linear_guess``)."""
        assert isinstance(target, Planes)
        return guesses(self, T_base_flange, target, gravity, thorough)

    @property
    def contact_factors(self) -> Array:
        """Return the factors R of the three functions on which the residual of a flat plane depends."""
        return self.R[:, :, :3]

    @property
    def equations_per_pose(self) -> int:
        """Return 2: the height and the slope of the line, however many points show it."""
        return 2

    @property
    def equations(self) -> Array:
        """Return two equations for a scan, one for a single point."""
        return np.minimum(self.equal.counts, self.equations_per_pose)

    @property
    def sigma_known(self) -> bool:
        """Return True: noise that is not stated is estimated from the scatter within scans."""
        return True

    def points_in_base(self, T_base_sensor: Array) -> tuple[Array, Array]:
        """Return the laser points in the base frame ``(P, 3)`` [m] and where each scan's begin ``(N + 1,)``."""
        x, z = self.points.T
        frames = np.repeat(T_base_sensor, self.equal.counts, axis=0)
        points = frames[:, :3, 0] * x[:, None] + frames[:, :3, 2] * z[:, None] + frames[:, :3, 3]
        return points, self.starts

    def scatter_in_base(self, T_base_sensor: Array) -> tuple[Array, Array, Array]:
        """Return number, mean and scatter of the points of each scan, from its triangular factor."""
        return scatter_in_base(self.R_metric[:, :3, :3], T_base_sensor)

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Planes:
        """Return the planes of least squared distance to the points at given poses of the sensor."""
        assert isinstance(target, Planes)
        counts, first, second = moments_in_base(self.R_metric[:, :3, :3], T_base_sensor)
        return fit_planes(target, self.target_index, counts, first, second)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the rows of two perfect points ``b = (1, x, z)``, with ``b . c = 0``, on the line in which the scanner's plane cuts the target."""
        assert isinstance(target, Planes)
        c, wrench, by_target = contact(T_base_sensor, target, index)
        on_line, reached = self.perfect_factors(c)
        return on_line @ wrench, on_line @ by_target, reached

    def perfect_factors(self, c: Array) -> tuple[Array, Array]:
        """Return factors F ``(N, 2, 3)`` of perfect rows, ``F c = 0`` at contact vectors c ``(N, 3)``, and which scans reach their plane."""
        size = np.linalg.norm(c, axis=1, keepdims=True)
        reached = size > 0
        return tangent_basis(
            np.where(reached, c / np.where(reached, size, 1.0), 1.0 / np.sqrt(3.0))
        ), reached[:, 0]

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``R c`` and its derivatives; effects on points add their own functions of the points to c."""
        assert isinstance(target, Planes)
        c, wrench, by_target = contact(T_base_sensor, target, self.target_index)
        R, residual = self.R[:, :, :3], np.einsum("nij,nj->ni", self.R[:, :, :3], c)
        extra = effect_rows(
            self.R, self.basis_names, point_effects, (T_base_sensor, target, self.target_index, c)
        )
        if point_effects:
            residual += extra @ np.concatenate([effect.coefficients for effect in point_effects])
        return Rows(residual, R @ wrench, R @ by_target, extra)

    def extra_columns(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any]) -> Array:
        """Return the rows of every effect's own functions of the points times what they add to c."""
        assert isinstance(target, Planes)
        where = T_base_sensor, target, self.target_index
        return effect_rows(self.R, self.basis_names, point_effects, (*where, contact_vectors(*where)))

    def _extended(
        self, c: Array, T_base_sensor: Array, planes: Planes, point_effects: Sequence[Any]
    ) -> Array:
        """Return the contact vectors c ``(N, 3)`` extended to all k functions that R keeps ``(N, k)``, with what the effects on points add."""
        if not point_effects and len(self.basis_names) == len(LINE_BASIS):
            return c
        full = np.zeros((len(c), len(self.basis_names)))
        full[:, :3] = c
        for effect in point_effects:
            index = [self.basis_names.index(name) for name in effect.basis_names]
            added = effect.contact_columns(T_base_sensor, planes, self.target_index, c)
            full[:, index] += added @ effect.coefficients
        return full

    def reweighted(self, T_base_sensor: Array, target: Target) -> LineLaser:
        """Return the scans weighted by the incidence of the estimate; a sigma that is not stated is estimated from the scatter within scans."""
        assert isinstance(target, Planes)
        c = contact_vectors(T_base_sensor, target, self.target_index)
        sigma = self.sigma
        if not self.sigma_stated and self.noise is None:
            unit = line_factors(self.points, self.starts, c, self.error_axis)
            scatter, freedom = scatter_within(unit, c, self.equal.counts)
            if freedom.sum() > 0:
                sigma = max(float(np.sqrt(robust_variance(scatter, freedom))), LEAST_SIGMA)
        if self.profiled:
            R = self._profile_factors(self.basis_names, c, sigma)
        elif self.basis_names == LINE_BASIS:
            R = line_factors(self.points, self.starts, c, self.error_axis, sigma)
        else:
            basis = point_basis(self.basis_names, self.points, self.error_axis)
            R = compress(basis / (sigma * self._incidence(c))[:, None], self.starts)
        return replace(self, weighted=R, sigma=sigma)

    def profiles(self, T_base_sensor: Array, target: Target, sigma: float) -> LineLaser:
        """Return the scans reduced to three rows each: shift, turn and curvature along the line; the scatter about them is left out.

        Each row has unit variance. Errors of a model are smooth along a scan, so they show in these rows; the scatter about them carries no
        information on the model and would only dilute statistical tests.
        """
        return replace(self, sigma=sigma, profiled=True).reweighted(T_base_sensor, target)

    def in_metres(self) -> tuple[LineLaser, float]:
        """Return the scans with equal weights of all points and rows in metres."""
        return replace(self, weighted=self.R_metric, profiled=False), 1.0

    def _profile_factors(self, names: Sequence[str], c: Array, sigma: float) -> Array:
        """Return the components ``(N, 3, k)`` of functions of the points along 1, t, t^2 of every scan (``profile_factors``)."""
        rows = profile_factors(names, self.points, self.starts, c, self.error_axis, sigma)
        return rows if self.noise is None else self.noise.whitening @ rows

    def scatter(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each scan the whitened squared scatter about its own line ``(N,)`` and its degrees of freedom ``(N,)``."""
        assert isinstance(target, Planes)
        c = contact_vectors(T_base_sensor, target, self.target_index)
        full = self._extended(c, T_base_sensor, target, point_effects)
        return scatter_within(self.R, c, self.equal.counts, full)

    def common_error(self, T_base_sensor: Array, target: Target) -> Array:
        """Return the derivative ``(N, m, 1)`` of the profile rows by an error [m] of the range that all points of a scan share."""
        assert isinstance(target, Planes)
        c = contact_vectors(T_base_sensor, target, self.target_index)
        return self._profile_factors(("ux", "uz"), c, self.sigma) @ c[:, 1:, None]

    def given_noise(self, noise: PoseNoise | None) -> LineLaser:
        """Return the scans with a noise from ``noise_within_poses``, for which their profiles are whitened."""
        return self if noise is None else replace(self, noise=noise, sigma=noise.sigma)

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each pose the sum of squared distances to its plane ``(N,)`` [m^2] and the number of points ``(N,)``."""
        assert isinstance(target, Planes)
        c = contact_vectors(T_base_sensor, target, self.target_index)
        full = self._extended(c, T_base_sensor, target, point_effects)
        f = np.einsum("nij,nj->ni", self.R_metric, full)
        return np.sum(f * f, axis=1), self.equal.counts

    @property
    def shift_rows(self) -> slice:
        """Return the first row: the whitened mean height."""
        return slice(0, 1)

    def shift(self, predicted: Array, residual: Array) -> tuple[Array, Array, Array]:
        """Return each scan's mean height [m] by a prediction and by the residual, and its standard error, ``(N,)`` each."""
        length = 1.0 / self.R[:, 0, 0]
        return predicted[:, 0] * length, residual[:, 0] * length, np.abs(length)

    def shown_residual(self, residual: Array) -> Array:
        """Return the mean height of each scan over its plane ``(N,)`` [m]."""
        return residual[:, 0] * (1.0 / self.R[:, 0, 0])

    def pieces(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any], effect: Any
    ) -> Pieces:
        """Return the pieces of the scans, with the points of each averaged."""
        assert isinstance(target, Planes)
        return cut_in_pieces(self, T_base_sensor, target, point_effects, effect)
