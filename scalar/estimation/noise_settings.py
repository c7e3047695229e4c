"""The thresholds of the noise within scans: when it is modelled as correlated, or as different from scan to scan."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.documented_setting import setting


@dataclass(frozen=True)
class WithinScanNoiseSettings:
    """When the noise within scans is modelled as correlated, or as different from scan to scan, instead of white and of one size."""

    least_points: int = setting(
        12, "points", "a shorter scan is not used to estimate the noise within scans",
        "chosen: nine degrees of freedom about a parabola, one more than the lags of the test",
    )  # fmt: skip
    least_scans: int = setting(
        10, "scans", "with fewer scans of that many points, the noise within scans is not estimated",
        "chosen: twice the four coefficients of the noise level, and two more",
    )  # fmt: skip
    winsorised_sigmas: float = setting(
        4.0, "robust standard deviations", "residuals of a scan are clipped to this size before the noise is estimated from them",
        "chosen: exceeded by one normal point in sixteen thousand; stray points and mixed pixels then have no more influence than that",
    )  # fmt: skip
    alpha: float = setting(
        1e-6, "1", "level of the tests whether the noise is correlated, whether it differs between scans, and whether it differs from what is stated",
        "chosen: a wrong answer would change every weight; departures that matter are far more significant",
    )  # fmt: skip
    least_gain: float = setting(
        20.0, "nats", "gain of log restricted likelihood with which a correlated component is accepted",
        "chosen: it changes every weight, and its shape, its length and its share have to be estimated",
    )  # fmt: skip
    longest_share: float = setting(
        0.25, "of a scan's length", "longest correlation length, and half the longest wave",
        "chosen: longer ones look like a shift or a rotation of the whole scan, which the variance components of whole poses describe",
    )  # fmt: skip
    confounded_likelihood: float = setting(
        3.0, "nats", "two descriptions of the noise are confounded if their log restricted likelihoods differ by less: shapes of correlation "
        "within scans, and variance components of whole poses", "odds of twenty to one",
    )  # fmt: skip
