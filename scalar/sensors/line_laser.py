"""A line scanner: points (x, 0, z) in its own plane, all of which lie on a plate.

``f_i = n . (T_base_sensor p_i) - d = [1, x_i, z_i] . c`` with the contact vector ``c = (n.o - d, n.X, n.Z)``, X, Z and o the axes and
the origin of the sensor in the base frame. A scan of any length is compressed to the rows ``R c`` (``scalar.sensors.compression``), each
point weighted by ``1 / (sigma |n . e_i|)``, e_i the direction in which the scanner errs: along the ray, or along z.
The incidence ``n . e_i`` is that of the current estimate, frozen while compressing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.geometry.planes import PARAMETERS_PER_PLANE, Planes
from scalar.geometry.se3 import Array, skew
from scalar.sensors.compression import compress, compress_keeping_q
from scalar.sensors.measurement import LEAST_SIGMA, Measurement, Rows, Target, stated_sigma

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_LEAST_INCIDENCE = 0.05  # |n . e|, 87 degrees: a grazing ray keeps a finite weight

LINE_BASIS = ("1", "x", "z")


def point_basis(names: Sequence[str], points: Array, error_axis: str) -> Array:
    """Return functions of the points ``(P, 2)`` [m] by name, ``(P, len(names))``.

    ``ux, uz`` is the direction in which the scanner errs and ``dx, dz`` the same times the squared range [m^2].
    """
    x, z = points[:, 0], points[:, 1]
    if tuple(names) == LINE_BASIS:
        return np.column_stack([np.ones_like(x), x, z])
    if error_axis == "ray":
        reach = np.maximum(np.sqrt(x * x + z * z), 1e-12)
        ux, uz = x / reach, z / reach
    else:
        reach, ux, uz = z, np.zeros_like(z), np.ones_like(z)
    functions = {
        "1": lambda: np.ones_like(x), "x": lambda: x, "z": lambda: z,
        "xx": lambda: x * x, "xz": lambda: x * z, "zz": lambda: z * z,
        "ux": lambda: ux, "uz": lambda: uz, "rx": lambda: reach * ux, "rz": lambda: reach * uz,
        "dx": lambda: reach**2 * ux, "dz": lambda: reach**2 * uz,
    }  # fmt: skip
    return np.column_stack([functions[name]() for name in names])


@dataclass(frozen=True, eq=False)
class LineLaser(Measurement):
    """The scans of a dataset, compressed.

    Attributes:
        points: ``(P, 2)`` [m], x and z of every point.
        starts: ``(N + 1,)``, pose i owns ``points[starts[i]:starts[i + 1]]``.
        error_axis: ``ray`` or ``z``.
        basis_names: Functions of a point that are kept; the first three are those of a flat plate.
        R: ``(N, k, k)``, whitened triangular factors.
        R_metric: ``(N, k, k)``, the same in metres, every point with the same weight.
        profiled: Whether R holds the three rows of ``profiles`` instead, ``(N, 3, k)``.
    """

    points: Array
    starts: Array
    target_index: Array
    error_axis: str
    sigma: float
    sigma_stated: bool
    basis_names: tuple[str, ...]
    R: Array
    R_metric: Array
    profiled: bool = False

    equations_per_pose = 2
    sees_sensor_rotation = True
    has_metric = True

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the rows that a scan is compressed to."""
        return self.R.shape[1]

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> LineLaser:
        """Return the scans of a dataset, each point with the same weight."""
        stated = dataset.sensor.noise is not None
        sigma = stated_sigma(dataset.sensor.noise)
        names = LINE_BASIS + tuple(name for name in dict.fromkeys(extra_basis) if name not in LINE_BASIS)
        basis = point_basis(names, dataset.points, dataset.sensor.error_axis)
        R_metric = compress(basis, dataset.starts)
        return cls(
            points=dataset.points,
            starts=dataset.starts,
            target_index=plane_targets(dataset)[0],
            error_axis=dataset.sensor.error_axis,
            sigma=sigma,
            sigma_stated=stated,
            basis_names=names,
            R=R_metric / sigma,
            R_metric=R_metric,
        )

    def initial_target(self, dataset: Dataset) -> Planes:
        """Return the planes at their rough guesses, one for each plane and session that occur."""
        return plane_targets(dataset)[1]

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Planes:
        """Return the planes of least squared distance to the points, the sensor's poses given."""
        assert isinstance(target, Planes)
        ends = np.cumsum(np.diff(self.starts))
        counts = np.diff(self.starts).astype(float)
        sums = np.add.reduceat(
            np.column_stack([self.points, _products(self.points)]), np.r_[0, ends[:-1]], axis=0
        )
        X, Z, o = T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2], T_base_sensor[:, :3, 3]
        A = np.stack([o, X, Z], axis=2)
        moments = np.empty((len(counts), 3, 3))
        moments[:, 0, 0] = counts
        moments[:, 0, 1:] = moments[:, 1:, 0] = sums[:, :2]
        moments[:, 1, 1], moments[:, 2, 2] = sums[:, 2], sums[:, 4]
        moments[:, 1, 2] = moments[:, 2, 1] = sums[:, 3]
        first = np.einsum("nij,nj->ni", A, moments[:, :, 0])
        second = A @ moments @ np.swapaxes(A, 1, 2)
        return fit_planes(target, self.target_index, counts, first, second)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the rows of two points on the line in which the scanner's plane cuts the plate: ``b . c = 0`` for both."""
        assert isinstance(target, Planes)
        c, wrench, by_target = contact(T_base_sensor, target, index)
        _, _, Vt = np.linalg.svd(c[:, None, :], full_matrices=True)
        on_line = Vt[:, 1:, :]
        return on_line @ wrench, on_line @ by_target, np.linalg.norm(c, axis=1) > 0

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``R c`` and its derivatives; effects on points add their own functions of the points to c."""
        assert isinstance(target, Planes)
        c, wrench, by_target = contact(T_base_sensor, target, self.target_index)
        full, extra = self._extended(c, T_base_sensor, target, point_effects)
        R = self.R[:, :, :3]
        residual = np.einsum("nij,nj->ni", self.R, full)
        return Rows(residual, R @ wrench, R @ by_target, self.R @ extra)

    def _extended(
        self, c: Array, T_base_sensor: Array, planes: Planes, point_effects: Sequence[Any]
    ) -> tuple[Array, Array]:
        """Return the contact vectors over all functions kept ``(N, k)`` and their derivatives by the effects' coefficients."""
        if not point_effects and len(self.basis_names) == len(LINE_BASIS):
            return c, np.zeros((len(c), 3, 0))
        full = np.zeros((len(c), len(self.basis_names)))
        full[:, :3] = c
        columns = [np.zeros((len(c), len(self.basis_names), 0))]
        for effect in point_effects:
            G = np.zeros((len(c), len(self.basis_names), len(effect.coefficients)))
            index = [self.basis_names.index(name) for name in effect.basis_names]
            G[:, index] = effect.contact_columns(T_base_sensor, planes, self.target_index, c)
            full += G @ effect.coefficients
            columns.append(G)
        return full, np.concatenate(columns, axis=2)

    def reweighted(self, T_base_sensor: Array, target: Target) -> LineLaser:
        """Return the scans weighted by the incidence of the estimate; sigma is measured where it was not stated."""
        assert isinstance(target, Planes)
        c, _, _ = contact(T_base_sensor, target, self.target_index)
        incidence = self._incidence(c)
        basis = point_basis(self.basis_names, self.points, self.error_axis)
        sigma = self.sigma
        if not self.sigma_stated:
            unit = compress(basis / incidence[:, None], self.starts)
            scatter, freedom = scatter_within(unit, c, np.diff(self.starts))
            if freedom.sum() > 0:
                sigma = max(float(np.sqrt(_robust_variance(scatter, freedom))), LEAST_SIGMA)
        whitened = basis / (sigma * incidence)[:, None]
        R = (
            self._profile_rows(whitened, c, 1.0 / (sigma * incidence))
            if self.profiled
            else compress(whitened, self.starts)
        )
        return replace(self, R=R, sigma=sigma)

    def profiles(self, T_base_sensor: Array, target: Target) -> LineLaser:
        """Return the scans reduced to three rows each: shift, turn and curvature along the line; the scatter about them is left out.

        What a model lacks is smooth along a scan, so it shows in these rows, each of unit variance. The scatter holds no news of it, and as a
        square it never averages to zero, so it is kept out of tests.
        """
        return replace(self, profiled=True).reweighted(T_base_sensor, target)

    def _profile_rows(self, whitened: Array, c: Array, weight: Array) -> Array:
        """Return the components ``(N, 3, k)`` of whitened functions ``(P, k)`` along 1, t, t^2 of every scan, t along its line.

        Args:
            whitened: Functions of the points, times their weights.
            c: ``(N, 3)``, contact vectors.
            weight: ``(P,)`` [1/m].
        """
        counts = np.diff(self.starts)
        along = np.repeat(np.column_stack([-c[:, 2], c[:, 1]]), counts, axis=0)
        t = np.sum(self.points * along, axis=1)
        t -= np.repeat(np.add.reduceat(t, self.starts[:-1]) / counts, counts)
        _, Q = compress_keeping_q(weight[:, None] * np.column_stack([np.ones_like(t), t, t * t]), self.starts)
        products = (Q[:, :, None] * whitened[:, None, :]).reshape(len(t), -1)
        return np.add.reduceat(products, self.starts[:-1]).reshape(len(counts), 3, -1)

    def scatter(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return per scan the whitened squared scatter about its own line and its degrees of freedom."""
        assert isinstance(target, Planes)
        c, _, _ = contact(T_base_sensor, target, self.target_index)
        full, _ = self._extended(c, T_base_sensor, target, point_effects)
        return scatter_within(self.R, c, np.diff(self.starts), full)

    def common_error(self, T_base_sensor: Array, target: Target) -> Array:
        """Return the derivative ``(N, m)`` of the profile rows by an error [m] of the range that all points of a scan share."""
        assert isinstance(target, Planes)
        c = contact(T_base_sensor, target, self.target_index)[0]
        incidence = self._incidence(c)
        direction = point_basis(("ux", "uz"), self.points, self.error_axis)
        per_point = np.sum(direction * np.repeat(c[:, 1:], np.diff(self.starts), axis=0), axis=1)
        return self._profile_rows(
            (per_point / (self.sigma * incidence))[:, None], c, 1.0 / (self.sigma * incidence)
        )[:, :, 0]

    def noise_floor(self, T_base_sensor: Array, target: Target) -> float:
        """Return the root mean square distance [m] to the plates that the noise of the points alone makes."""
        assert isinstance(target, Planes)
        incidence = self._incidence(contact(T_base_sensor, target, self.target_index)[0])
        return self.sigma * float(np.sqrt(np.mean(incidence**2)))

    def _incidence(self, c: Array) -> Array:
        """Return ``|n . e_i|`` of every point ``(P,)``, e_i the direction in which the scanner errs."""
        counts = np.diff(self.starts)
        ux, uz = point_basis(("ux", "uz"), self.points, self.error_axis).T
        along = np.repeat(c[:, 1], counts) * ux + np.repeat(c[:, 2], counts) * uz
        return np.maximum(np.abs(along), _LEAST_INCIDENCE)

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return per pose the sum of squared distances to the plate [m^2] and the number of points."""
        assert isinstance(target, Planes)
        c, _, _ = contact(T_base_sensor, target, self.target_index)
        full, _ = self._extended(c, T_base_sensor, target, point_effects)
        f = np.einsum("nij,nj->ni", self.R_metric, full)
        return np.sum(f * f, axis=1), np.diff(self.starts)


def contact(T_base_sensor: Array, planes: Planes, index: Array) -> tuple[Array, Array, Array]:
    """Return the contact vectors ``(N, 3)``, their wrenches ``(N, 3, 6)`` and derivatives by (u, v, d) ``(N, 3, 3)``."""
    X, Z, o = T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2], T_base_sensor[:, :3, 3]
    normals = planes.normals
    n = normals[index]
    carriers = np.stack([o, X, Z], axis=1)
    c = np.einsum("nkx,nx->nk", carriers, n)
    c[:, 0] -= planes.distances[index]
    wrench = np.zeros((len(n), 3, 6))
    wrench[:, :, :3] = carriers @ skew(normals)[index]  # carrier x normal
    wrench[:, 0, 3:] = n
    by_target = np.zeros((len(n), 3, PARAMETERS_PER_PLANE))
    by_target[:, :, :2] = carriers @ planes.normal_derivatives[index]
    by_target[:, 0, 2] = -1.0
    return c, wrench, by_target


def scatter_within(R: Array, c: Array, counts: Array, full: Array | None = None) -> tuple[Array, Array]:
    """Return per scan the squared residual that no line explains ``(N,)`` and its degrees of freedom ``(N,)``.

    Of the residual ``R c`` the part along ``R (1, 0, 0)`` (a shift) and ``R (0, -c_z, c_x)`` (a turn of the line) is removed: what
    remains does not depend on where robot, scanner and plate are.

    Args:
        R: ``(N, m, k)``.
        c: ``(N, 3)``, contact vectors of the flat plate.
        counts: ``(N,)``, points a scan.
        full: ``(N, k)``, contact vectors with what effects on points and plates add; c where None.
    """
    f = np.einsum("nij,nj->ni", R[:, :, :3], c) if full is None else np.einsum("nij,nj->ni", R, full)
    shift = R[:, :, 0]
    turn = R[:, :, 2] * c[:, 1:2] - R[:, :, 1] * c[:, 2:3]
    for _ in range(2):
        f = f - shift * _ratio(np.sum(f * shift, 1), np.sum(shift * shift, 1))
        turn = turn - shift * _ratio(np.sum(turn * shift, 1), np.sum(shift * shift, 1))
        f = f - turn * _ratio(np.sum(f * turn, 1), np.sum(turn * turn, 1))
    return np.sum(f * f, axis=1), np.maximum(counts - 2, 0)


def _ratio(top: Array, bottom: Array) -> Array:
    return (top / np.where(bottom > 0, bottom, 1.0))[:, None]


def _robust_variance(scatter: Array, freedom: Array) -> float:
    """Return the variance from per-scan scatters: a pooled mean of the scans that are not wildly above the median."""
    use = freedom > 0
    each = scatter[use] / freedom[use]
    keep = each <= 4.0 * np.median(each) + 1e-30
    return float(np.sum(scatter[use][keep]) / np.sum(freedom[use][keep]))


def _products(points: Array) -> Array:
    x, z = points[:, 0], points[:, 1]
    return np.column_stack([x * x, x * z, z * z])


def plane_targets(dataset: Dataset) -> tuple[Array, Planes]:
    """Return which target each pose measures ``(N,)`` and the targets: every plane that occurs, once for each session."""
    plane = dataset.plane_index
    session = dataset.session if dataset.session is not None else np.zeros(dataset.n_poses, dtype=int)
    pairs, index = np.unique(np.column_stack([session, plane]), axis=0, return_inverse=True)
    several = len(np.unique(session)) > 1
    names = [dataset.planes[k].name + (f"@{s + 1}" if several else "") for s, k in pairs]
    normals = np.array([dataset.planes[k].normal for _, k in pairs])
    distances = np.array([dataset.planes[k].distance for _, k in pairs])
    return index.reshape(-1), Planes.at(names, normals, distances)


def fit_planes(target: Planes, index: Array, counts: Array, first: Array, second: Array) -> Planes:
    """Return the planes of least squared distance from per-pose moments of points in the base frame.

    Args:
        target: Gives names and the sign of each normal; kept where too few points lie on a plane.
        index: ``(N,)``, which plane each pose measures.
        counts: ``(N,)``, ``first``: ``(N, 3)``, ``second``: ``(N, 3, 3)``: number, sum and sum of products of the points.
    """
    normals, distances = target.normals, target.distances.copy()
    for k in range(len(normals)):
        mine = index == k
        total = counts[mine].sum()
        if total < 3:
            continue
        mean = first[mine].sum(0) / total
        _, vectors = np.linalg.eigh(second[mine].sum(0) / total - np.outer(mean, mean))
        normal = vectors[:, 0] * (1.0 if vectors[:, 0] @ normals[k] >= 0 else -1.0)
        normals[k], distances[k] = normal, normal @ mean
    return Planes.at(target.names, normals, distances)
