"""The thresholds that the estimate of the noise within scans needs; their values stand with all others in ``scalar.estimation.settings``."""

from __future__ import annotations

from typing import Protocol


class NoiseThresholds(Protocol):
    """When noise within scans is modelled as other than white and of one size."""

    @property
    def least_points(self) -> int:
        """Points that a scan must have to be used."""
        ...

    @property
    def least_scans(self) -> int:
        """Scans of so many points, or nothing is said."""
        ...

    @property
    def winsorised_sigmas(self) -> float:
        """Robust standard deviations of a scan to which residuals are clipped."""
        ...

    @property
    def alpha(self) -> float:
        """Chance of finding that white noise is correlated, that it changes with range or incidence, or is not as stated, where it is."""
        ...

    @property
    def least_gain(self) -> float:
        """Restricted log likelihood [nats] that a correlated component must gain."""
        ...

    @property
    def longest_share(self) -> float:
        """Longest correlation length, as a share of a scan's length."""
        ...

    @property
    def confounded_likelihood(self) -> float:
        """Restricted log likelihood [nats] within which two shapes of correlation are confounded."""
        ...
