"""Thresholds of noise: variance components between poses, and the autocorrelation of their residuals."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class VarianceComponentSettings:
    """When poses vary by more than the noise of their points, and when that is no noise."""

    least_repeatability: float = setting(
        2e-5, "rad", "of each joint; poses that repeat better are no finding, any arm scatters by as much",
        "chosen: the best data sheets of small arms state a position repeatability (ISO 9283) of 0.01 mm, at half a metre",
    )  # fmt: skip
    worst_repeatability: float = setting(
        4e-4, "rad", "of each joint; poses that repeat worse are no jitter, something acts on them",
        "four times the worst orientation repeatability of an ABB IRB 1600, 87 microradians; its position repeats to 37 micrometres "
        "(Slamani, Nubiola and Bonev, Industrial Robot 39, 2012)",
    )  # fmt: skip


@dataclass(frozen=True)
class AutocorrelationSettings:
    """When residuals of neighbouring poses are autocorrelated."""

    alpha_autocorrelation: float = setting(
        1e-3,
        "1",
        "chance of autocorrelation where there is none, corrected for all orders that were tried",
        "chosen: a variance component that goes unreported is a smaller fault than one that is reported for a pattern",
    )
    least_poses: int = setting(
        12,
        "poses",
        "of a plane, for neighbours to be near one another",
        "chosen: four times the neighbours that each has",
    )
