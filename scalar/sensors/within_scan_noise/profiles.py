"""The points of all scans, sorted along each scan, and their deviations from the scan's own line or parabola.

With f a point's height over the plane [m], sigma its assumed noise and ``n . e`` the incidence, ``y = f / (sigma |n . e|)`` is the height in
standard deviations. A scan's own line or parabola has the columns ``[1, t, t^2] / (sigma |n . e|)``, t along the line, orthonormal in Q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.profile import LINE_BASIS, point_basis, profile_columns
from scalar.sensors.scans import Scans


@dataclass(frozen=True, eq=False)
class Profiles:
    """N scans of P points in all.

    Attributes:
        starts: ``(N + 1,)``, scan s owns the points ``starts[s]:starts[s + 1]``.
        height: ``(P,)``, y, in standard deviations sigma.
        Q: ``(P, 3)``, orthonormal columns of each scan: shift, turn, curvature.
        curvature: ``(N,)`` [m], the component of y along the third column of Q per unit of c [1/m] in a height ``f = c t^2``, t in metres.
        angle: ``(P,)`` [rad], of the ray; ascending within a scan.
        along: ``(P,)`` [m], position along the scan's line.
        log_range: ``(N,)``, mean logarithm of the range [m].
        log_incidence: ``(N,)``, mean logarithm of ``|n . e|``.
        target_index: ``(N,)``, index of the plane that each scan measures.
    """

    starts: Array
    height: Array
    Q: Array
    curvature: Array
    angle: Array
    along: Array
    log_range: Array
    log_incidence: Array
    target_index: Array

    @classmethod
    def of(cls, scans: Scans, contact: Array, incidence: Array) -> Profiles:
        """Return the profiles of scans.

        Args:
            scans: What was measured.
            contact: ``(N, 3)``, contact vectors (``scalar.sensors.profile``).
            incidence: ``(P,)``, ``|n . e|`` of every point.
        """
        points, starts = scans.points, scans.starts
        counts = np.diff(starts)
        weight = 1.0 / (scans.sigma * incidence)
        t, R, Q = profile_columns(points, starts, contact, weight)
        height = np.sum(
            point_basis(LINE_BASIS, points, scans.error_axis) * np.repeat(contact, counts, axis=0), axis=1
        )
        angle = np.arctan2(points[:, 0], points[:, 1])
        order = np.lexsort((angle, np.repeat(np.arange(len(counts)), counts)))
        length = np.maximum(np.linalg.norm(contact[:, 1:], axis=1), 1e-12)
        reach = np.maximum(np.hypot(points[:, 0], points[:, 1]), 1e-9)

        def mean(values: Array) -> Array:
            return np.add.reduceat(values, starts[:-1]) / counts

        return cls(
            starts,
            (weight * height)[order],
            Q[order],
            R[:, 2, 2] / length**2,  # t of profile_columns is in metres times the length
            angle[order],
            (t / np.repeat(length, counts))[order],
            mean(np.log(reach)),
            mean(np.log(incidence)),
            scans.target_index,
        )

    @property
    def counts(self) -> Array:
        """Return the number of points of each scan ``(N,)``."""
        return np.diff(self.starts)

    @property
    def scan(self) -> Array:
        """Return the index of each point's scan ``(P,)``."""
        return np.repeat(np.arange(len(self.starts) - 1), self.counts)

    def sum(self, values: Array) -> Array:
        """Return the sums ``(N,)`` or ``(N, k)`` of values ``(P,)`` or ``(P, k)`` over the points of each scan."""
        return np.add.reduceat(values, self.starts[:-1], axis=0)

    def without(self, values: Array, columns: int) -> Array:
        """Return values ``(P,)`` less each scan's projection on the first columns of Q: 2 for its line, 3 for its parabola."""
        Q, counts = self.Q[:, :columns], self.counts
        for _ in range(2):  # the second projection removes the rounding errors of the first
            values = values - np.sum(Q * np.repeat(self.sum(Q * values[:, None]), counts, axis=0), axis=1)
        return values

    def clipped(self, values: Array, sigmas: float) -> Array:
        """Return values ``(P,)`` clipped to ``sigmas`` robust standard deviations of their own scan (from the median of absolute values)."""
        size = np.abs(values)
        ranked = size[np.lexsort((size, self.scan))]
        first, counts = self.starts[:-1], self.counts
        median = 0.5 * (ranked[first + (counts - 1) // 2] + ranked[first + counts // 2])
        limit = np.repeat(sigmas * median / 0.6745, counts)  # 0.6745: the median of |x|, x standard normal
        return np.where(limit > 0, np.clip(values, -limit, limit), values)

    def about_lines(self, trusted: Array) -> Array:
        """Return heights ``(P,)``, in standard deviations, about each scan's own line, without the curvature that the scans of a plane share.

        A bowed plane, or a range error that is not linear, bends all scans of a plane alike, so their common curvature is not noise.

        Args:
            trusted: ``(N,)`` bool, the scans from which that curvature is estimated.
        """
        bent = self.sum(self.Q[:, 2] * self.height)
        shared = np.zeros(len(bent))
        for k in np.unique(self.target_index):
            mine = (self.target_index == k) & trusted & (self.curvature > 0)
            if mine.any():
                shared[self.target_index == k] = _weighted_median(
                    bent[mine] / self.curvature[mine], self.curvature[mine]
                )
        height = self.height - self.Q[:, 2] * np.repeat(shared * self.curvature, self.counts)
        return self.without(height, 2)


def _weighted_median(values: Array, weights: Array) -> float:
    """Return the least value such that it and all smaller ones have half of the total weight."""
    order = np.argsort(values, kind="stable")
    cumulated = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(cumulated, 0.5 * cumulated[-1])])
