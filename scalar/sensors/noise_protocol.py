"""The part of the protocol of a sensor kind that concerns noise: how rows are weighted, and what is known of their noise.

Every method has a default that is right for a kind whose rows have independent noise of one size.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.noise_thresholds import NoiseThresholds
from scalar.sensors.pose_noise import NoiseComponent, PoseNoise
from scalar.sensors.target import Target


class NoiseProtocol(ABC):
    """The weights and the noise of a measurement of N poses with m rows each.

    Attributes:
        rows_per_pose: m, the number of rows to which a pose is reduced.
        sigma: Standard deviation of the sensor [m], stated or estimated.
        sigma_stated: Whether the dataset stated it and the residual of a fit did not show that the statement is too large.
        noise: The noise within poses for which the rows are whitened, or None.
    """

    rows_per_pose: int
    sigma: float
    sigma_stated: bool
    noise: PoseNoise | None = None

    def reweighted(self, T_base_sensor: Array, target: Target) -> Any:
        """Return the same measurement, whitened for the geometry of the estimate; by default the weights do not depend on it."""
        return self

    def counting(self, coefficients: int) -> Self:
        """Return the same measurement, which counts so many coefficients of effects among the parameters when it estimates its noise from a residual.

        By default no noise is estimated from a residual, and the measurement itself is returned.
        """
        return self

    def weighted_like(self, other: Any) -> Self:
        """Return the same measurement, with the weights that another measurement of the same poses has estimated.

        Squared residuals of two models can be compared only under the same weights. By default no weights are estimated, and the measurement
        itself is returned.

        Args:
            other: A measurement of the same poses, reweighted at an estimate.
        """
        return self

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the components of the noise that ``reweighted`` estimates from the residual of a fit, as files list them; by default none."""
        return ()

    @property
    def ratio_to_stated(self) -> float | None:
        """Return the standard deviation for which the rows are weighted over the stated one; None if none was stated."""
        return 1.0 if self.sigma_stated else None

    @property
    def listed_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the components of the sensor's own noise that files list; white noise of one stated size is not listed."""
        return (*self.noise_components, *self.estimated_noise)

    @property
    def sigma_known(self) -> bool:
        """Return whether ``sigma`` is known independently of the fit: stated, or measured from the scatter of the points."""
        return self.sigma_stated

    def scatter(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each pose the squared whitened residual that no model can explain, and its degrees of freedom, ``(N,)``; by default zero."""
        none = np.zeros(len(T_base_sensor))
        return none, none.astype(int)

    def profiles(self, T_base_sensor: Array, target: Target, sigma: float) -> Any:
        """Return the same measurement with noise ``sigma`` [m] and without the scatter that no model can explain, for statistical tests."""
        return self

    def in_metres(self) -> tuple[Any, float]:
        """Return the measurement with equal weights of all points, and the factor that converts its rows to metres."""
        return self, self.sigma

    def noise_floor(self, T_base_sensor: Array, target: Target) -> float:
        """Return the root mean square residual [m] that noise alone would cause at a pose."""
        return self.sigma * float(np.sqrt(self.rows_per_pose))

    def common_error(self, T_base_sensor: Array, target: Target) -> Array:
        """Return the derivatives of the rows by k errors common to all points of a pose, ``(N, m, k)`` [1/m]; by default one for each row."""
        m = self.rows_per_pose
        return np.array(np.broadcast_to(np.eye(m) / self.sigma, (len(T_base_sensor), m, m)))

    def between_poses(self, residual: Array, variance: float) -> float:
        """Return the standard deviation [m] of the errors of whole poses, beyond the noise of their points.

        Args:
            residual: ``(N, m)``, whitened rows.
            variance: The sum of squares of the rows over their degrees of freedom.
        """
        return float(np.sqrt(max(variance - 1.0, 0.0))) * self.sigma

    def noise_within_poses(
        self, T_base_sensor: Array, target: Target, settings: NoiseThresholds
    ) -> PoseNoise | None:
        """Return the noise within poses as their points show it, or None if it is white and of one size; by default None.

        Args:
            T_base_sensor: ``(N, 4, 4)``, near the estimate.
            target: What is measured.
            settings: Thresholds.
        """
        return None

    def covariance_of_extended_errors(self, T_base_sensor: Array, target: Target) -> Array | None:
        """Return the covariance ``(N, m, m)`` of the rows by errors of the sensor that are correlated over a whole pose, or None, the default.

        Such an error shifts and rotates the measurement as a whole, as an error of the arm does. A single pose cannot distinguish the two.
        """
        return None

    @property
    def noise_components(self) -> tuple[NoiseComponent, ...]:
        """Return the components of the noise for which the rows are whitened, without white noise."""
        return () if self.noise is None else self.noise.components

    def given_noise(self, noise: PoseNoise | None) -> Self:
        """Return the same measurement with a noise that ``noise_within_poses`` returned, for which ``profiles`` whitens; by default unchanged."""
        return self
