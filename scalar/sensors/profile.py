"""Line scans of planes: functions of a point, the contact vector, and the scatter about the scan's own line.

The contact vector of a scan is ``c = (n.o - d, n.X, n.Z)``, n and d being the normal and distance of its plane, o, X and Z the origin and
axes of the sensor in the base frame: a point (x, z) is ``[1, x, z] . c`` above the plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import groupby
from typing import Any

import numpy as np

from scalar import kernels
from scalar.geometry.planes import PARAMETERS_PER_PLANE, Planes
from scalar.geometry.se3 import Array, skew
from scalar.kernels.contacts import contacts, scatter
from scalar.sensors.compression import compress, compress_keeping_q

LINE_BASIS = ("1", "x", "z")
_CARRIERS = [3, 0, 2]  # columns of the sensor's pose: its origin, X and Z
_LEAST_INCIDENCE = 0.05  # |n . e|, 87 degrees: a grazing ray keeps a finite weight
_CODES = {
    "1": (0, 0, 0, 0),
    "x": (0, 0, 1, 0),
    "z": (0, 0, 0, 1),
    "xx": (0, 0, 2, 0),
    "xz": (0, 0, 1, 1),
    "zz": (0, 0, 0, 2),
    "ux": (1, 0, 0, 0),
    "uz": (2, 0, 0, 0),
    "rx": (1, 1, 0, 0),
    "rz": (2, 1, 0, 0),
    "dx": (1, 2, 0, 0),
    "dz": (2, 2, 0, 0),
}
"""(along, r, i, j) of each stem of a name, as ``_code`` returns them."""


def _code(name: str) -> tuple[int, int, int, int]:
    """Return (along, r, i, j) of a function ``u reach^r x^i z^j`` of a point: u is 1, u_x or u_z."""
    stem, colon, powers = name.partition(":")
    along, r, i, j = _CODES[stem]
    return (along, r, i + int(powers[0]), j + int(powers[1])) if colon else (along, r, i, j)


def point_basis(names: Sequence[str], points: Array, error_axis: str) -> Array:
    """Return functions of the points ``(P, 2)`` [m] by name, ``(P, len(names))``.

    ``1, x, z, xx, xz, zz`` are powers of the coordinates. ``ux, uz`` is the direction in which the scanner errs, ``rx, rz`` the same times
    the range [m], ``dx, dz`` times its square [m^2], and ``ux:ij, uz:ij`` times ``x^i z^j``. If the scanner errs along z, z is its range.
    """
    x, z = points[:, 0], points[:, 1]
    if tuple(names) == LINE_BASIS:
        return np.column_stack([np.ones_like(x), x, z])
    if error_axis == "ray":
        reach = np.maximum(np.sqrt(x * x + z * z), 1e-12)
        u = np.ones_like(x), x / reach, z / reach
    else:
        reach, u = z, (np.ones_like(z), np.zeros_like(z), np.ones_like(z))
    factors, raised = (reach, x, z), cache(lambda k, power: factors[k] ** power)
    found = np.empty((len(points), len(names)))
    for column, (along, *powers) in zip(found.T, map(_code, names), strict=True):
        column[:] = u[along]
        for k, power in enumerate(powers):
            if power:  # a power of zero takes ten times as long as a product
                column *= factors[k] if power == 1 else raised(k, power)
    return found


def incidence(points: Array, starts: Array, c: Array, error_axis: str) -> Array:
    """Return ``|n . e_i|`` ``(P,)`` of every point, but at least 0.05, where e_i is the direction in which the scanner errs.

    Args:
        points: ``(P, 2)`` [m], x and z of all points in the scanner's plane, scan after scan.
        starts: ``(N + 1,)``, index of the first point of each scan, and P.
        c: ``(N, 3)``, the contact vectors of the scans (``contact``).
        error_axis: ``ray`` or ``z``, the axis along which the scanner errs.
    """
    counts = np.diff(starts)
    ux, uz = point_basis(("ux", "uz"), points, error_axis).T
    along = np.repeat(c[:, 1], counts) * ux + np.repeat(c[:, 2], counts) * uz
    return np.maximum(np.abs(along), _LEAST_INCIDENCE)


def line_factors(
    points: Array,
    starts: Array,
    c: Array | None = None,
    error_axis: str = "ray",
    sigma: float = 1.0,
) -> Array:
    """Return the triangular factors ``(N, 3, 3)`` of ``[1, x, z]`` over the points of every scan.

    Args:
        points: ``(P, 2)`` [m].
        starts: ``(N + 1,)``, where each scan's points begin.
        c: ``(N, 3)``, contact vectors, so that each point has the weight ``1 / (sigma |n . e_i|)``; None for weights of 1.
        error_axis: The direction e_i in which the scanner errs, ``ray`` or ``z``.
        sigma: Standard deviation of a point along e_i [m].
    """
    compiled = kernels.compress(points, starts, c, along_z=error_axis != "ray", sigma=sigma)
    if compiled is not None:
        return compiled
    basis = point_basis(LINE_BASIS, points, error_axis)
    if c is not None:
        basis /= (sigma * incidence(points, starts, c, error_axis))[:, None]
    return compress(basis, starts)


@dataclass(frozen=True, eq=False)
class PointFactors:
    """The triangular factors of functions of the points of every scan, with equal weights of all points; they are computed when first used.

    Attributes:
        names: Names of the functions, as for ``point_basis``.
        points: ``(P, 2)`` [m].
        starts: ``(N + 1,)``, where each scan's points begin.
        error_axis: The direction in which the scanner errs.
    """

    names: tuple[str, ...]
    points: Array
    starts: Array
    error_axis: str

    @cached_property
    def counts(self) -> Array:
        """Return the number of points of every scan ``(N,)``; computed once and therefore read-only."""
        counts = np.diff(self.starts)
        counts.setflags(write=False)
        return counts

    @cached_property
    def factors(self) -> Array:
        """Return the factors ``(N, k, k)`` [m]."""
        if self.names == LINE_BASIS:
            return line_factors(self.points, self.starts)
        return compress(point_basis(self.names, self.points, self.error_axis), self.starts)


def contact_vectors(T_base_sensor: Array, planes: Planes, index: Array) -> Array:
    """Return the contact vectors ``(N, 3)`` alone; arguments as for ``contact``."""
    compiled = contacts(T_base_sensor, planes.normals, planes.distances, index)
    if compiled is not None:
        return compiled
    c = np.einsum("nxk,nx->nk", T_base_sensor[:, :3, _CARRIERS], planes.normals[index])
    c[:, 0] -= planes.distances[index]
    return c


def contact(T_base_sensor: Array, planes: Planes, index: Array) -> tuple[Array, Array, Array]:
    """Return the contact vectors ``(N, 3)``, their wrenches ``(N, 3, 6)`` and derivatives by (u, v, d) ``(N, 3, 3)``.

    Args:
        T_base_sensor: ``(N, 4, 4)``.
        planes: K planes.
        index: ``(N,)``, which of them each pose measures.
    """
    normals = planes.normals
    n = normals[index]
    c = contact_vectors(T_base_sensor, planes, index)
    carriers = np.swapaxes(T_base_sensor[:, :3, _CARRIERS], 1, 2)
    wrench = np.zeros((len(n), 3, 6))
    wrench[:, :, :3] = carriers @ skew(normals)[index]  # carrier x normal
    wrench[:, 0, 3:] = n
    by_target = np.zeros((len(n), 3, PARAMETERS_PER_PLANE))
    by_target[:, :, :2] = carriers @ planes.normal_derivatives[index]
    by_target[:, 0, 2] = -1.0
    return c, wrench, by_target


def profile_columns(points: Array, starts: Array, c: Array, weight: Array) -> tuple[Array, Array, Array]:
    """Return t along the line of every scan ``(P,)``, and the factors R ``(N, 3, 3)`` and Q ``(P, 3)`` of its weighted columns 1, t, t^2.

    Args:
        points: ``(P, 2)`` [m].
        starts: ``(N + 1,)``, where each scan's points begin.
        c: ``(N, 3)``, contact vectors; t is in metres times the length of ``(c_x, c_z)``, from the scan's mean.
        weight: ``(P,)`` [1/m], weights of the points.
    """
    counts = np.diff(starts)
    along = np.repeat(np.column_stack([-c[:, 2], c[:, 1]]), counts, axis=0)
    t = np.sum(points * along, axis=1)
    t -= np.repeat(np.add.reduceat(t, starts[:-1]) / counts, counts)
    R, Q = compress_keeping_q(weight[:, None] * np.column_stack([np.ones_like(t), t, t * t]), starts)
    return t, R, Q


def profile_factors(
    names: Sequence[str], points: Array, starts: Array, c: Array, error_axis: str, sigma: float
) -> Array:
    """Return the components ``(N, 3, k)`` of whitened functions of the points along the columns of ``profile_columns``.

    Args:
        names: Names of the functions, as for ``point_basis``; each is multiplied by the weights that points have in ``line_factors``.
        points, starts, c: As in ``profile_columns``.
        error_axis: The direction in which the scanner errs.
        sigma: Standard deviation of a point along it [m].
    """
    codes = np.array([_code(name) for name in names], dtype=np.int64).reshape(-1, 4)
    compiled = kernels.profiles(points, starts, c, codes, along_z=error_axis != "ray", sigma=sigma)
    if compiled is not None:
        return compiled
    weight = 1.0 / (sigma * incidence(points, starts, c, error_axis))
    values = point_basis(names, points, error_axis) * weight[:, None]
    return profile_rows(points, starts, c, weight, values)


def profile_rows(points: Array, starts: Array, c: Array, weight: Array, values: Array) -> Array:
    """Return the components ``(N, 3, k)`` of k functions of the points along the columns of ``profile_columns``.

    Args:
        points, starts, c, weight: As in ``profile_columns``.
        values: ``(P, k)``, the functions' values at the points.
    """
    Q = profile_columns(points, starts, c, weight)[2]
    products = (Q[:, :, None] * values[:, None, :]).reshape(len(Q), -1)
    return np.add.reduceat(products, starts[:-1]).reshape(len(c), 3, -1)


def effect_rows(
    R: Array, names: Sequence[str], point_effects: Sequence[Any], where: tuple[Array, Planes, Array, Array]
) -> Array:
    """Return the derivatives ``(N, m, e)`` of the rows ``R c`` by the e coefficients of effects on points.

    Args:
        R: ``(N, m, k)``, factors of k functions of the points.
        names: ``(k,)``, names of the functions.
        point_effects: The effects, bound to their poses.
        where: The other arguments of ``contact_columns`` of such an effect: ``T_base_sensor`` ``(N, 4, 4)``, the planes, which of them each pose
            measures ``(N,)``, and the contact vectors c ``(N, 3)``.
    """
    columns = [np.zeros((*R.shape[:2], 0))]
    for functions, same in groupby(point_effects, key=lambda effect: effect.basis_names):
        # Effects that are shares of the same effect have its columns times these shares.
        whole: dict[Any, Array] = {}
        shares: list[tuple[Any, Array | None]] = []
        for effect in same:
            key, constant, share = effect.constant_and_shares() or (len(shares), effect, None)
            if key not in whole:
                whole[key] = constant.contact_columns(*where)
            shares.append((key, share))
        own = R[:, :, [names.index(name) for name in functions]] @ _side_by_side(list(whole.values()))
        ends = np.cumsum([added.shape[2] for added in whole.values()])
        parts = dict(zip(whole, np.split(own, ends[:-1], axis=2), strict=True))
        columns += [
            parts[key] if share is None else parts[key] * share[:, None, None] for key, share in shares
        ]
    return _side_by_side(columns)


def _side_by_side(columns: Sequence[Array]) -> Array:
    """Return arrays ``(N, m, ...)`` of columns as one array, which may be one of them."""
    some = [each for each in columns if each.shape[2]] or columns
    return np.ascontiguousarray(some[0]) if len(some) == 1 else np.concatenate(some, axis=2)


def scatter_within(R: Array, c: Array, counts: Array, full: Array | None = None) -> tuple[Array, Array]:
    """Return for each scan the squared residual that no line explains ``(N,)`` and its degrees of freedom ``(N,)``.

    From the residual ``R c``, the parts along ``R (1, 0, 0)`` (a shift of the line) and ``R (0, -c_z, c_x)`` (a rotation of the line) are removed.
    What remains does not depend on the poses of robot, scanner and plane.

    Args:
        R: ``(N, m, k)``, factors of k functions of the points, the first three those of a flat plane.
        c: ``(N, 3)``, contact vectors of the flat plane.
        counts: ``(N,)``, number of points of each scan.
        full: ``(N, k)``, contact vectors with the contributions of effects on points and planes; None if there are none.
    """
    freedom = np.maximum(counts - 2, 0)
    compiled = scatter(R, c, full)
    if compiled is not None:
        return compiled, freedom
    f = np.einsum("nij,nj->ni", R[:, :, :3], c) if full is None else np.einsum("nij,nj->ni", R, full)
    shift = R[:, :, 0]
    turn = R[:, :, 2] * c[:, 1:2] - R[:, :, 1] * c[:, 2:3]
    for _ in range(2):
        f = f - _along(f, shift)
        turn = turn - _along(turn, shift)
        f = f - _along(f, turn)
    return np.sum(f * f, axis=1), freedom


def _along(rows: Array, directions: Array) -> Array:
    """Return the components of rows ``(N, m)`` along directions ``(N, m)`` of any length; zero along one without length."""
    squares = np.einsum("ni,ni->n", directions, directions)
    return (
        directions * (np.einsum("ni,ni->n", rows, directions) / np.where(squares > 0, squares, 1.0))[:, None]
    )


def robust_variance(scatter: Array, freedom: Array) -> float:
    """Return the variance from the scatters of scans ``(N,)``: pooled over the scans whose own variance is at most four times the median."""
    use = freedom > 0
    each = scatter[use] / freedom[use]
    keep = each <= 4.0 * np.median(each) + 1e-30
    return float(np.sum(scatter[use][keep]) / np.sum(freedom[use][keep]))
