"""Where scanner and planes are under one reading of a recording, and how near its scans then lie to the planes.

Which plane a scan lies on shows only where scanner and planes are known, and dataset.yaml has both roughly. They are found together: every scan
belongs to each plane with a weight that falls with its distance, scanner and planes take a Gauss-Newton step under these weights, and the distance at
which a scan counts as near shrinks from step to step (deterministic annealing; Rose, 1998). The arm stays nominal. Stated places have
priors with the standard deviations of their usual errors. A wrong reading that is compensated by a scanner mounted the other way round therefore has
a high cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.geometry.planes import PARAMETERS_PER_PLANE, Planes
from scalar.geometry.se3 import Array, cross, exp_so3, log_so3, transform
from scalar.units import DEG, MM

SENSOR_SHIFT_STD, SENSOR_TURN_STD = 50 * MM, 10 * DEG
"""Prior standard deviations of the pose of the scanner on the flange, along and about each axis, from the stated pose: it is measured by hand."""
PLANE_TILT_STD, PLANE_SHIFT_STD = 10 * DEG, 100 * MM
"""Prior standard deviations of a plane from its guess: about each of two axes, and of its distance. Chosen."""
ZERO_STD = 10 * DEG
"""Prior standard deviation of the zero of a joint, where it is free: the zeros from which fits start are farther apart than a fit reaches."""
FIRST_DISTANCES = 40 * MM, 100 * MM
"""Standard deviation of a scan's distance from its plane in the first step: the error of good guesses and of rough ones. Both are tried: with the
larger one, planes that are near each other may share their scans wrongly, and with the smaller one, rough guesses miss them."""
LAST_DISTANCE = 5 * MM
"""Standard deviation of a scan's distance from its plane in the last steps: the error of a nominal arm."""
NO_PLANE = 3.0
"""Number of standard deviations from its plane at which a scan is as likely to lie on no plane."""
_SHRINKING, _SETTLING = 10, 3  # steps in which that distance shrinks, and steps after these
_MOST_TURN = 0.5  # rad by which the scanner may turn in one step: farther away its rotation is not linear


@dataclass(frozen=True, eq=False)
class Placement:
    """Scanner and planes as fitted to the scans under one reading.

    Attributes:
        T_flange_sensor: ``(4, 4)``.
        planes: K planes.
        cost: Negative log posterior, up to a constant: half the squared deviations from stated places in prior standard deviations, less the log
            likelihoods of the scans. A scan that lies on no plane costs ``NO_PLANE**2 / 2``.
        turn: How far the scanner is turned from its stated pose [rad].
        zero: By how much the free joint turned further [rad]; 0 if none is free.
    """

    T_flange_sensor: Array
    planes: Planes
    cost: float
    turn: float
    zero: float = 0.0


@dataclass(frozen=True, eq=False)
class JointAxis:
    """The axis of a joint at S scans, in the base frame: where it is does not depend on the zero of its own joint.

    Attributes:
        directions: ``(S, 3)``, unit.
        points: ``(S, 3)`` [m], a point of the axis each.
    """

    directions: Array
    points: Array

    def turned(self, T: Array, angle: float) -> Array:
        """Return transforms ``(S, 4, 4)`` to the base frame after a turn of the joint by an angle [rad]."""
        R = exp_so3(self.directions * angle)
        moved = np.einsum("sij,sj->si", R, T[:, :3, 3] - self.points) + self.points
        return transform(R @ T[:, :3, :3], moved)

    def column(self, frames: Array, normals: Array) -> Array:
        """Return the derivatives ``(S, K, 3)`` of ``c`` of each scan and plane by the angle; ``frames`` ``(S, 4, 4)``, the scanner's."""
        z = self.directions
        moves = np.stack(
            [cross(z, frames[:, :3, 3] - self.points), cross(z, frames[:, :3, 0]), cross(z, frames[:, :3, 2])]
        )
        return np.einsum("rsx,kx->skr", moves, normals)


def line_factors(scans: Sequence[Array]) -> Array:
    """Return triangular factors ``(S, 3, 3)`` of 1, x, z at the points ``(M, 2)`` [m] of each scan, divided by the root of their number."""
    found = np.zeros((len(scans), 3, 3))
    for factor, points in zip(found, scans, strict=True):
        triangle = np.asarray(np.linalg.qr(np.column_stack([np.ones(len(points)), points]), mode="r"))
        factor[: len(triangle)] = triangle / np.sqrt(len(points))
    return found


def distances_from(frames: Array, factors: Array, planes: Planes) -> Array:
    """Return root mean square distances of scans from planes, ``(S, K)`` [m].

    Args:
        frames: ``(S, 4, 4)``, the scanner in the base frame.
        factors: ``(S, 3, 3)`` from ``line_factors``.
        planes: K planes.
    """
    return np.sqrt(np.sum(_residual(frames, factors, planes) ** 2, axis=-1))


def place(
    T_base_flange: Array,
    factors: Array,
    T_stated: Array,
    stated: Planes,
    used: Array | None = None,
    axis: JointAxis | None = None,
) -> Placement:
    """Return scanner and planes as S scans have them, with a nominal arm: the better of the fits from rough and from good guesses.

    Args:
        T_base_flange: ``(S, 4, 4)``, the flange at each scan.
        factors: ``(S, 3, 3)`` from ``line_factors``.
        T_stated: ``(4, 4)``, the scanner's stated pose on the flange.
        stated: K planes as guessed.
        used: ``(K,)`` bool, the planes on which scans may lie; None for all.
        axis: The axis of a joint whose zero is free; None if none is.
    """
    scans = _Scans(T_base_flange, factors, T_stated, stated, used, axis)
    return min((scans.placed(first) for first in FIRST_DISTANCES), key=lambda placement: placement.cost)


@dataclass(frozen=True, eq=False)
class _Scans:
    """What is given to a fit; the attributes are the arguments of ``place``."""

    T_base_flange: Array
    factors: Array
    T_stated: Array
    stated: Planes
    used: Array | None
    axis: JointAxis | None

    def placed(self, first: float) -> Placement:
        """Return the placement that is found where scans within ``first`` [m] of a plane count as near at first."""
        prior_std = self.prior_std
        placement = Placement(self.T_stated, self.stated, np.inf, 0.0)
        for scale in (*np.geomspace(first, LAST_DISTANCE, _SHRINKING), *[LAST_DISTANCE] * _SETTLING):
            frames = self.frames(placement)
            residual = _residual(frames, self.factors, placement.planes)
            weights = self.likelihoods(residual, scale)
            weights /= (weights.sum(axis=1, keepdims=True) + _on_none()) * scale**2
            J = _jacobian(frames, self.factors, placement.planes, self.axis).reshape(-1, len(prior_std))
            weighted = J * np.repeat(weights.ravel(), 3)[:, None]
            normal = weighted.T @ J + np.diag(prior_std**-2.0)
            step = -np.linalg.solve(
                normal, weighted.T @ residual.ravel() + self.deviations(placement) / prior_std**2
            )
            placement = _moved(placement, step, free=self.axis is not None)
        residual = _residual(self.frames(placement), self.factors, placement.planes)
        likelihood = self.likelihoods(residual, LAST_DISTANCE).sum(axis=1) + _on_none()
        deviations = self.deviations(placement)
        cost = 0.5 * float(np.sum((deviations / prior_std) ** 2)) - float(np.sum(np.log(likelihood)))
        return replace(placement, cost=cost, turn=float(np.linalg.norm(deviations[3:6])))

    @property
    def prior_std(self) -> Array:
        """Return the prior standard deviations ``(P,)`` of what is fitted, in the order of the Jacobian [m, rad]."""
        plane = np.tile([PLANE_TILT_STD, PLANE_TILT_STD, PLANE_SHIFT_STD], len(self.stated.distances))
        zero = np.full(0 if self.axis is None else 1, ZERO_STD)
        return np.concatenate([np.full(3, SENSOR_SHIFT_STD), np.full(3, SENSOR_TURN_STD), plane, zero])

    def frames(self, placement: Placement) -> Array:
        """Return the scanner in the base frame at each scan, ``(S, 4, 4)``."""
        T = self.T_base_flange @ placement.T_flange_sensor
        return T if self.axis is None else self.axis.turned(T, placement.zero)

    def likelihoods(self, residual: Array, scale: float) -> Array:
        """Return the relative likelihood of each scan on each plane, ``(S, K)``, with distances of a standard deviation ``scale`` [m]."""
        found = np.exp(-0.5 * np.sum(residual**2, axis=-1) / scale**2)
        return found if self.used is None else found * self.used

    def deviations(self, placement: Placement) -> Array:
        """Return the deviations ``(P,)`` of what is fitted from what is stated, in the order of the Jacobian [m, rad]."""
        T, R = placement.T_flange_sensor, self.T_stated[:3, :3].T
        shift, turn = R @ (T[:3, 3] - self.T_stated[:3, 3]), log_so3(R @ T[:3, :3])
        zero = [] if self.axis is None else [placement.zero]
        return np.concatenate([shift, turn, placement.planes.vector - self.stated.vector, zero])


def _on_none() -> float:
    """Return the likelihood of a scan that lies on no plane, relative to one that lies exactly on a plane."""
    return float(np.exp(-0.5 * NO_PLANE**2))


def _residual(frames: Array, factors: Array, planes: Planes) -> Array:
    """Return ``R c`` of each scan and plane, ``(S, K, 3)`` [m]: its square is the mean square distance of the points from the plane."""
    n = planes.normals
    heights = frames[:, :3, 3] @ n.T - planes.distances
    c = np.stack([heights, frames[:, :3, 0] @ n.T, frames[:, :3, 2] @ n.T], axis=-1)
    return np.einsum("sij,skj->ski", factors, c)


def _jacobian(frames: Array, factors: Array, planes: Planes, axis: JointAxis | None) -> Array:
    """Return the derivatives of the residual ``(S, K, 3, P)`` by a motion of the scanner in its frame, the planes' coordinates and a free zero."""
    S, K = len(frames), len(planes.distances)
    n = np.einsum("sxy,kx->sky", frames[:, :3, :3], planes.normals)  # in the scanner's frame
    found = np.zeros((S, K, 3, 6 + PARAMETERS_PER_PLANE * K + (axis is not None)))
    found[:, :, 0, :3] = n
    found[:, :, 1, 3:6] = cross(np.array([1.0, 0.0, 0.0]), n)
    found[:, :, 2, 3:6] = cross(np.array([0.0, 0.0, 1.0]), n)
    for k, by_normal in enumerate(planes.normal_derivatives):
        first = 6 + PARAMETERS_PER_PLANE * k
        for row, column in enumerate((3, 0, 2)):
            found[:, k, row, first : first + 2] = frames[:, :3, column] @ by_normal
        found[:, k, 0, first + 2] = -1.0
    if axis is not None:
        found[..., -1] = axis.column(frames, planes.normals)
    return np.einsum("sij,skjp->skip", factors, found)


def _moved(placement: Placement, step: Array, *, free: bool) -> Placement:
    """Return a placement after a step in the order of the Jacobian; ``free`` says whether its last number is that of a free zero."""
    of_planes = step[6:-1] if free else step[6:]
    planes = placement.planes.with_vector(placement.planes.vector + of_planes)
    T = placement.T_flange_sensor @ _motion(step[:6])
    return replace(placement, T_flange_sensor=T, planes=planes, zero=placement.zero + float(step[-1]) * free)


def _motion(step: Array) -> Array:
    """Return the motion ``(4, 4)`` of a step: a shift ``(3,)`` [m] and a turn ``(3,)`` [rad], which is limited."""
    size = float(np.linalg.norm(step[3:]))
    return transform(exp_so3(step[3:] * min(1.0, _MOST_TURN / max(size, _MOST_TURN))), step[:3])
