"""The noise of a tracker's measurements: stated for all, stated for each, or estimated from the residuals of a fit.

Positions and orientations have different units, so their noises weigh them against each other. If one of the two is stated, the other is
estimated from the root mean square of its own residuals; if neither is, their ratio is chosen so that both have residuals of the same number
of standard deviations. The residuals of a fit are smaller than the noise, because its parameters adapt to it; they are scaled up accordingly
(Förstner's estimator of variance components, with the same factor for all rows).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.pose_noise import ROTATION_NOISE, NoiseComponent
from scalar.sensors.rows import LEAST_SIGMA, stated_sigma

_TYPICAL_REACH = 0.1
"""[m] Until it is estimated, the noise of an angle is that of a position over this distance."""
_REACHES = (0.01, 10.0)
"""[m] Bounds of the ratio of the noise of positions to that of orientations, if neither is stated."""
_UNCHANGED = 1e-3  # a smaller relative change of an estimated noise is not applied


@dataclass(frozen=True, eq=False)
class TrackerNoise:
    """Standard deviations of the measurements of K targets in N poses.

    Attributes:
        seen: ``(N, K)`` bool, which targets each pose shows.
        position: ``(N, K)`` [m], of each coordinate.
        rotation: ``(N, K)`` [rad], about each axis; None if no orientation was measured.
        position_stated: Whether the noise of positions is stated.
        rotation_stated: Whether that of orientations is stated.
        unknowns: Approximate number of parameters that a fit estimates.
        fixed: Whether a noise that was estimated before is not estimated again.
    """

    seen: Array
    position: Array
    rotation: Array | None
    position_stated: bool
    rotation_stated: bool
    unknowns: int
    fixed: bool = False

    @classmethod
    def of(
        cls,
        seen: Array,
        position: tuple[float | None, Array | None],
        rotation: tuple[float | None, Array | None] | None,
        unknowns: int,
    ) -> TrackerNoise:
        """Return the noise as it is stated, or a guess.

        Args:
            seen: ``(N, K)`` bool.
            position: The noise stated for all [m], and that for each measurement ``(N, K)`` [m], which takes precedence; None if not stated.
            rotation: The same for orientations [rad]; None if none was measured.
            unknowns: Approximate number of parameters that a fit estimates.
        """
        stated, each = position
        sigma = np.full(seen.shape, stated_sigma(stated)) if each is None else np.maximum(each, LEAST_SIGMA)
        if rotation is None:
            return cls(seen, sigma, None, stated is not None or each is not None, True, unknowns)
        of_all, of_each = rotation
        if of_each is not None:
            turn = np.maximum(of_each, LEAST_SIGMA)
        else:
            typical = float(np.median(sigma[seen])) / _TYPICAL_REACH
            turn = np.full(seen.shape, typical if of_all is None else max(of_all, LEAST_SIGMA))
        return cls(
            seen,
            sigma,
            turn,
            stated is not None or each is not None,
            of_all is not None or of_each is not None,
            unknowns,
        )

    @property
    def typical(self) -> float:
        """Return the root mean square standard deviation of a coordinate [m]."""
        values = self.position[self.seen]
        first = float(values[0])
        return first if np.all(values == first) else float(np.sqrt(np.mean(values**2)))

    @property
    def of_poses(self) -> Array:
        """Return the standard deviation ``(N,)`` [m], along one axis, of a shift that is common to all targets of a pose."""
        information = np.sum(self.seen / self.position**2, axis=1)
        single = self.position[np.arange(len(self.seen)), np.argmax(self.seen, axis=1)]
        return np.where(self.seen.sum(axis=1) == 1, single, 1.0 / np.sqrt(np.maximum(information, 1e-300)))

    def weights(self) -> Array:
        """Return one over the standard deviation of each row ``(N, 3 K)``, or ``(N, 6 K)`` with orientations; zero for targets that are not seen."""
        per_axis = [np.repeat(self.seen / self.position, 3, axis=1)]
        if self.rotation is not None:
            per_axis.append(np.repeat(self.seen / self.rotation, 3, axis=1))
        return np.concatenate(per_axis, axis=1)

    def estimated(self, shift: Array, turn: Array) -> TrackerNoise:
        """Return the noise with the part that is not stated estimated from residuals; the same object if that changes nothing.

        Args:
            shift: ``(N, K, 3)`` [m], residuals of positions.
            turn: ``(N, K, 3)`` [rad], residuals of orientations.
        """
        if self.rotation is None or self.fixed or (self.position_stated and self.rotation_stated):
            return self
        n = 6 * int(self.seen.sum())
        share = np.sqrt(n / max(n - self.unknowns, n / 2))
        of_position = _relative(shift, self.position, self.seen) * share
        of_rotation = _relative(turn, self.rotation, self.seen) * share
        if self.rotation_stated:
            factor = max(of_position, LEAST_SIGMA / self.typical)
            return self if _same(factor) else replace(self, position=self.position * factor)
        if self.position_stated:
            rotation = np.maximum(self.rotation * of_rotation, LEAST_SIGMA)
        else:
            reach = self.typical * of_position / (self.rotation * max(of_rotation, 1e-300))
            rotation = self.typical / np.clip(reach, *_REACHES)
        return self if _same(float(np.max(rotation / self.rotation))) else replace(self, rotation=rotation)

    def component(self) -> NoiseComponent | None:
        """Return the estimated noise of orientations as files list it; None if it is stated or orientations were not measured."""
        if self.rotation is None or self.rotation_stated:
            return None
        value, n = float(self.rotation[self.seen][0]), 3 * int(self.seen.sum())
        sentence = "the noise of the measured orientations is estimated from what the model leaves"
        return NoiseComponent(ROTATION_NOISE, {}, value, value / np.sqrt(2.0 * n), "rad", sentence)


def _relative(residual: Array, sigma: Array, seen: Array) -> float:
    """Return the root mean square of residuals ``(N, K, 3)`` in standard deviations ``(N, K)``."""
    return float(np.sqrt(np.mean((residual[seen] / sigma[seen][:, None]) ** 2)))


def _same(factor: float) -> bool:
    return abs(factor - 1.0) < _UNCHANGED
