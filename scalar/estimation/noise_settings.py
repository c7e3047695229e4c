"""The thresholds of the noise within scans: when it is modelled as correlated, or as different from scan to scan."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.documented_setting import setting


@dataclass(frozen=True)
class WithinScanNoiseSettings:
    """When the noise within scans is modelled as correlated, or as different from scan to scan, instead of white and of one size."""

    least_points: int = setting(
        12, "points", "a shorter scan says nothing of its noise",
        "chosen: nine degrees of freedom about a parabola, one more than the lags of the test",
    )  # fmt: skip
    least_scans: int = setting(
        10, "scans", "fewer scans with that many points say nothing of the noise", "chosen: twice the four coefficients of the level, and two more"
    )  # fmt: skip
    winsorised_sigmas: float = setting(
        4.0, "robust standard deviations", "of a scan, to which residuals are clipped before anything is learned from them",
        "chosen: one normal point in sixteen thousand; stray points and mixed pixels count for no more",
    )  # fmt: skip
    alpha: float = setting(
        1e-6, "1", "chance of finding that white noise is correlated, that scans differ in it, or that it is not as stated, where it is",
        "chosen: each changes every weight; what matters is far beyond it",
    )  # fmt: skip
    least_gain: float = setting(
        20.0, "nats", "of restricted likelihood that a correlated component must gain",
        "chosen: it changes every weight, and the component has a shape, a length and a share to be estimated",
    )  # fmt: skip
    longest_share: float = setting(
        0.25, "of a scan's length", "longest correlation length, and half the longest wave",
        "chosen: what is longer looks like a shift or a turn of the scan, and is a matter of the variance components",
    )  # fmt: skip
    confounded_likelihood: float = setting(
        3.0, "nats", "of restricted likelihood within which two noises are confounded: shapes of correlation within scans, and "
        "variance components of whole poses", "odds of twenty",
    )  # fmt: skip
