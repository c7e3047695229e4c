"""The ways to calibrate that a study compares, by name.

``manifold`` is ours; ``published-READING`` is the paper's own, the square root of its constraints read in one
of three ways; with ``-2018`` behind, lmfit's defaults are those of the paper's year.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.estimation.result import Calibration

INITIAL = "initial"
"""The model as the dataset declares it, before any calibration: a state to compare with, not a method."""

BOUND = "cramer-rao"
"""What no unbiased estimator does better than: a yardstick in the tables, not a method."""

EFFICIENT = "efficient"
"""The estimate to first order that attains the bound, from the same noise: a yardstick seed by seed."""

CONVERGED = "converged"
"""Status of a fit that ended at an optimum."""


def _manifold(dataset: Dataset) -> Calibration:
    from scalar.estimation.calibrate import calibrate

    return calibrate(dataset)


def _published(reading: str, dataset: Dataset, defaults: str = "now") -> Calibration:
    from scalar.baseline.fit import calibrate_published

    # The compressed rows have the sum of squares of all points, and are faster to ask.
    return calibrate_published(dataset, reading=reading, points="compressed", defaults=defaults)


METHODS: dict[str, Callable[[Dataset], Calibration]] = {
    "manifold": _manifold,
    "published-abs": partial(_published, "abs"),
    "published-abs-2018": partial(_published, "abs", defaults="2018"),
    "published-clip": partial(_published, "clip"),
    "published-raise": partial(_published, "raise"),
}
