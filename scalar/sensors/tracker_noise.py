"""The noise of a tracker's measurements: stated for all, stated for each, or estimated from the residuals of a fit.

Positions and orientations have different units, so the ratio of their noises decides how they are weighted against each other. A noise that is not
stated, or stated clearly larger than the residuals are, is estimated from the root mean square of its own residuals; if neither noise is stated,
their ratio is chosen so that the residuals of both have the same size in standard deviations. The residuals of a fit are smaller than the noise,
because its parameters adapt to the noise; they are scaled up accordingly (Förstner's estimator of variance components, with the same factor for all
rows).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.pose_noise import ROTATION_NOISE, NoiseComponent
from scalar.sensors.residual_noise import (
    UNCHANGED,
    estimated_position_noise,
    factor_within_poses,
    noise_factor,
    rows_within_poses,
    scaled_up,
)
from scalar.sensors.rows import LEAST_SIGMA, stated_sigma

_TYPICAL_REACH = 0.1
"""[m] Until it is estimated, the noise of an angle is assumed to be that of a position divided by this distance."""
_REACHES = (0.01, 10.0)
"""[m] Bounds of the ratio of the noise of positions to that of orientations, if neither is stated."""
_CLEARLY_LARGER = 1.5  # a stated noise of orientations is too small if their residuals exceed those of positions by it, in standard deviations


@dataclass(frozen=True, eq=False)
class TrackerNoise:
    """Standard deviations of the measurements of K targets in N poses.

    Attributes:
        seen: ``(N, K)`` bool, which targets each pose shows.
        position: ``(N, K)`` [m], of each coordinate.
        rotation: ``(N, K)`` [rad], about each axis; None if no orientation was measured.
        position_stated: Whether ``position`` is as stated.
        rotation_stated: Whether ``rotation`` is as stated; True if no orientation was measured.
        unknowns: Approximate number of parameters that a fit estimates.
        stated: Root mean square of the stated noise of positions [m]; None if none is stated or no target was seen.
        position_estimated: Whether ``position`` is estimated from residuals.
        measured: Whether the targets of each pose show the noise of positions.
        fixed: Whether the noise stays as it is, even one that was estimated before, and is not estimated again.
    """

    seen: Array
    position: Array
    rotation: Array | None
    position_stated: bool
    rotation_stated: bool
    unknowns: int
    stated: float | None = None
    position_estimated: bool = False
    measured: bool = False
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
        of_all_positions, of_each_position = position
        if of_each_position is None:
            sigma = np.full(seen.shape, stated_sigma(of_all_positions))
        else:
            sigma = np.maximum(of_each_position, LEAST_SIGMA)
        position_stated = of_all_positions is not None or of_each_position is not None
        turn, rotation_stated = None, True
        if rotation is not None:
            of_all, of_each = rotation
            rotation_stated = of_all is not None or of_each is not None
            typical = float(np.median(sigma[seen])) / _TYPICAL_REACH
            turn = np.full(seen.shape, typical if of_all is None else max(of_all, LEAST_SIGMA))
            if of_each is not None:
                turn = np.maximum(of_each, LEAST_SIGMA)
        noise = cls(seen, sigma, turn, position_stated, rotation_stated, unknowns)
        return replace(noise, stated=noise.typical) if position_stated and seen.any() else noise

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

    @property
    def ratio_to_stated(self) -> float | None:
        """Return the noise of positions over the stated one; None if none was stated."""
        return None if self.stated is None else self.typical / self.stated

    def estimated(self, residual: Array, moved: Array) -> TrackerNoise:
        """Return the noise as residuals show it where it is not stated, or stated wrongly; the same object if that changes nothing.

        Args:
            residual: ``(N, m)`` [m, rad], predicted minus measured positions, then orientations if they were measured.
            moved: ``(N, m, 6)``, derivatives by a rigid motion of the sensor.
        """
        N, K = self.seen.shape
        shift, turn = residual[:, : 3 * K].reshape(N, K, 3), residual[:, 3 * K :].reshape(N, -1, 3)
        rows = 3 * int(self.seen.sum()) * (1 if self.rotation is None else 2)
        of_position = scaled_up(_relative(shift, self.position, self.seen), rows, self.unknowns)
        by_positions, by_turns = self._within_poses(residual, moved)
        factor = by_positions
        if factor is None:
            factor = noise_factor(of_position, rows, self.unknowns, stated=self.position_stated)
        if self.rotation is None:
            return self._scaled(factor, measured=by_positions is not None)
        of_rotation = scaled_up(_relative(turn, self.rotation, self.seen), rows, self.unknowns)
        if self.rotation_stated and not self.position_stated and by_positions is None:
            factor = max(of_position, LEAST_SIGMA / self.typical)
        scaled = self._scaled(factor, measured=by_positions is not None)
        if by_turns is not None:
            turn_factor = by_turns
        elif self.rotation_stated:
            # What the model lacks moves and turns a target. A turn that is larger than that, in standard deviations, is noise.
            turn_factor = noise_factor(of_rotation, rows, self.unknowns, stated=True)
            beyond = of_rotation / max(of_position / factor, 1.0)
            turn_factor = beyond if beyond > _CLEARLY_LARGER else turn_factor
        elif self.position_stated:
            turn_factor = of_rotation
        else:
            reach = self.typical * of_position / (self.rotation * max(of_rotation, 1e-300))
            turn_factor = float(np.max(scaled.typical / np.clip(reach, *_REACHES) / self.rotation))
        if _same(turn_factor):
            return scaled
        rotation = np.maximum(self.rotation * turn_factor, LEAST_SIGMA)
        return replace(scaled, rotation=rotation, rotation_stated=False)

    def _within_poses(self, residual: Array, moved: Array) -> tuple[float | None, float | None]:
        """Return what ``factor_within_poses`` gives for positions and for orientations, None for what the targets of a pose do not show."""
        K = self.seen.shape[1]
        if K == 1:
            return None, None
        weights = self.weights()
        residual, moved = residual * weights, moved * weights[:, :, None]

        def factor(part: slice, stated: bool) -> float | None:
            return factor_within_poses(residual[:, part], moved[:, part], weights[:, part] > 0, stated=stated)

        positions, turns = slice(None, 3 * K), slice(3 * K, None)
        return (
            factor(positions, self.position_stated),
            None if self.rotation is None else factor(turns, self.rotation_stated),
        )

    def _scaled(self, factor: float, *, measured: bool) -> TrackerNoise:
        """Return the noise with that of positions multiplied by a factor that residuals show; the same object if it is 1."""
        if _same(factor):
            return replace(self, measured=True) if measured and not self.measured else self
        position = np.maximum(self.position * factor, LEAST_SIGMA)
        return replace(
            self, position=position, position_stated=False, position_estimated=True, measured=measured
        )

    def components(self) -> tuple[NoiseComponent, ...]:
        """Return the estimated noise of positions and of orientations as files list them; none that is stated, guessed or not measured."""
        found = []
        if self.position_estimated:
            rows = rows_within_poses(self.seen) if self.measured else 3.0 * float(self.seen.sum())
            found.append(estimated_position_noise(self.typical, rows, self.stated))
        if self.rotation is not None and not self.rotation_stated:
            value, n = float(self.rotation[self.seen][0]), 3 * int(self.seen.sum())
            sentence = "the noise of the measured orientations is estimated from what the model leaves"
            found.append(NoiseComponent(ROTATION_NOISE, {}, value, value / np.sqrt(2.0 * n), "rad", sentence))
        return tuple(found)


def _relative(residual: Array, sigma: Array, seen: Array) -> float:
    """Return the root mean square of residuals ``(N, K, 3)`` in standard deviations ``(N, K)``."""
    return float(np.sqrt(np.mean((residual[seen] / sigma[seen][:, None]) ** 2)))


def _same(factor: float) -> bool:
    return abs(factor - 1.0) < UNCHANGED


def placed(values: Array | None, pose: Array, item: Array, shape: tuple[int, int]) -> Array | None:
    """Return a column of the table as ``(N, K)``, with 1 for targets that were not measured; None if there is no such column."""
    if values is None:
        return None
    found = np.ones(shape)
    found[pose, item] = values
    return found
