"""The thresholds that the estimate of the noise within scans needs; their values are in ``scalar.estimation.settings``, with all others."""

from __future__ import annotations

from typing import Protocol


class NoiseThresholds(Protocol):
    """The thresholds that decide whether the noise within scans is modelled as white and of one size."""

    @property
    def least_points(self) -> int:
        """Least number of points of a scan that is used."""
        ...

    @property
    def least_scans(self) -> int:
        """Least number of such scans; with fewer, the noise within scans is not estimated."""
        ...

    @property
    def winsorised_sigmas(self) -> float:
        """Number of robust standard deviations of its scan to which a residual is clipped."""
        ...

    @property
    def alpha(self) -> float:
        """Significance level of each test that noise is white, that it is the same at all ranges and incidences, and that it is as stated."""
        ...

    @property
    def least_gain(self) -> float:
        """Least gain in restricted log likelihood [nats] for which a correlated component is added."""
        ...

    @property
    def longest_share(self) -> float:
        """Longest correlation length, as a share of a scan's length."""
        ...

    @property
    def confounded_likelihood(self) -> float:
        """Difference in restricted log likelihood [nats] below which two shapes of correlation are confounded."""
        ...
