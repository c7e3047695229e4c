"""Thresholds of random errors: variance components of whole poses, and the autocorrelation of their residuals."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class VarianceComponentSettings:
    """Which standard deviations of the joint angles are reported as jitter."""

    least_repeatability: float = setting(
        2e-5, "rad", "a jitter with a smaller standard deviation of each joint angle is no finding, because any arm has one of that size",
        "chosen: the best data sheets of small arms state a position repeatability (ISO 9283) of 0.01 mm, at half a metre",
    )  # fmt: skip
    worst_repeatability: float = setting(
        4e-4, "rad", "a scatter with a larger standard deviation of each joint angle is no jitter but has another cause, which is unattributed",
        "four times the worst orientation repeatability of an ABB IRB 1600, 87 microradians; its position repeats to 37 micrometres "
        "(Slamani, Nubiola and Bonev, Industrial Robot 39, 2012)",
    )  # fmt: skip


@dataclass(frozen=True)
class AutocorrelationSettings:
    """When residuals of neighbouring poses are autocorrelated."""

    alpha_autocorrelation: float = setting(
        1e-3,
        "1",
        "probability of finding an autocorrelation where there is none, corrected for all orders of the poses that are tested",
        "chosen: a variance component that goes unreported is a smaller fault than one that is reported for a pattern",
    )
    least_poses: int = setting(
        12,
        "poses",
        "the poses of a target plane, or those with one value of a recorded column, are tested for structure only if there are at least this many",
        "chosen: four times the neighbours of each pose, so that neighbours are near one another",
    )
