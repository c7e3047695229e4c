"""The noise of scans: the residual that the noise of points alone causes, and how much more whole scans scatter.

The residual of a scan about its own line is the noise of the scanner and of the surface (``scalar.sensors.within_scan_noise``). Only that part
needs SciPy, which is imported where it is used, so that reading a dataset does not import it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors.noise_thresholds import NoiseThresholds
from scalar.sensors.plane_targets import OnPlanes
from scalar.sensors.pose_noise import PoseNoise
from scalar.sensors.profile import contact_vectors, incidence
from scalar.sensors.target import Target

if TYPE_CHECKING:
    from scalar.sensors.within_scan_noise import Profiles


class NoisyScans(OnPlanes):
    """Scans of planes whose points have noise. A subclass holds the points and the rows to which the scans are compressed.

    Attributes:
        points, starts, error_axis, R, R_metric: As in ``scalar.sensors.scans.Scans``.
        noise: The noise within scans if it was found to be correlated or to vary from scan to scan; None if it is white and equally large in all.
    """

    points: Array
    starts: Array
    error_axis: str
    R: Array
    R_metric: Array
    noise: PoseNoise | None

    def by_range_scale(self, T_base_sensor: Array, target: Target) -> Array | None:
        """Return the derivatives ``(N, m)`` of the rows by a factor on all ranges.

        It moves a point (x, z) by its own place, or by (0, z) if the scanner errs along z. The point's height over the plane changes by what these
        two coordinates contribute to it, which is a part of the contact vector.
        """
        assert isinstance(target, Planes)
        by_coordinates = contact_vectors(T_base_sensor, target, self.target_index)
        by_coordinates[:, : 1 if self.error_axis == "ray" else 2] = 0.0
        return np.einsum("nij,nj->ni", self.R[:, :, :3], by_coordinates)

    def noise_floor(self, T_base_sensor: Array, target: Target) -> float:
        """Return the root mean square distance [m] to the planes that the noise of the points alone causes."""
        assert isinstance(target, Planes)
        slant = self._incidence(contact_vectors(T_base_sensor, target, self.target_index))
        level = 1.0 if self.noise is None else np.repeat(self.noise.level, np.diff(self.starts))
        return self.sigma * float(np.sqrt(np.mean((level * slant) ** 2)))

    def _profiles(self, T_base_sensor: Array, target: Target) -> Profiles:
        from scalar.sensors.within_scan_noise import Profiles

        assert isinstance(target, Planes)
        c = contact_vectors(T_base_sensor, target, self.target_index)
        return Profiles.of(self, c, self._incidence(c))

    def noise_within_poses(
        self, T_base_sensor: Array, target: Target, settings: NoiseThresholds
    ) -> PoseNoise | None:
        """Return the noise within scans, from the scans' residuals about their own lines (``within_scan_noise``)."""
        from scalar.sensors.within_scan_noise import noise_within_scans

        profiles = self._profiles(T_base_sensor, target)
        return noise_within_scans(profiles, self.sigma, self.sigma_stated, settings)

    def covariance_of_extended_errors(self, T_base_sensor: Array, target: Target) -> Array:
        """Return the covariance ``(N, 3, 3)`` of the profile rows from errors that are correlated over a whole scan (``long_waves``)."""
        from scalar.sensors.within_scan_noise import long_waves

        return long_waves(self._profiles(T_base_sensor, target), self.noise)

    def between_poses(self, residual: Array, variance: float) -> float:
        """Return the standard deviation [m] of the scans' mean heights beyond the noise of their points."""
        # The first profile row is the whitened mean: its length in metres is one over the norm of the weights.
        weights = np.abs(self.R[:, 0, 0])
        first = np.mean(residual[:, 0] ** 2) - 1.0
        return float(np.sqrt(max(first, 0.0))) / float(np.sqrt(np.mean(weights**2)))

    def _incidence(self, c: Array) -> Array:
        return incidence(self.points, self.starts, c, self.error_axis)
