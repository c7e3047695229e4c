"""The methods of calibration that a study compares, by name: the proposed method and the variants of the baseline.

The baseline is the original paper's own method. Its constraints contain a square root whose argument may become negative. The original paper does
not say what happens then, so there is a variant for each reading of the root, and one with the solver's defaults of 2018, the paper's year.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.estimation.result import Calibration

INITIAL = "initial"
"""The model as the dataset declares it, before any calibration: a state to compare with, not a method."""

BOUND = "cramer-rao"
"""The Cramér-Rao bound, which no unbiased estimator falls below: a reference in the tables, not a method."""

EFFICIENT = "efficient"
"""The efficient estimate to first order, from the noise of each seed: it attains the bound; a reference for each seed, not a method."""

CONVERGED = "converged"
"""Status of a fit that ended at an optimum."""

PROPOSED = "proposed"
"""Name of the proposed method in tables, configs and keys of numbers."""

TOLERANCE = "proposed-tolerance"
"""The proposed method where the dataset states the tolerances of the arm, which are then the standard deviations of a prior on its geometry."""


@dataclass(frozen=True)
class Method:
    """One method of calibration.

    Attributes:
        name: Name in tables, configs and names of files.
        reading: How the baseline reads the root of a negative number, a key of ``scalar.baseline.fit.READINGS``; None: the proposed method.
        defaults: The baseline's solver settings, a key of ``scalar.baseline.fit.DEFAULTS``.
        nan_policy: What the baseline does with a NaN, one of ``scalar.baseline.batched.NAN_POLICIES``; used in the fits of sweeps only.
        states_tolerance: Whether the dataset states how far the arm may differ from its data sheet; sweeps state it, as the standard deviations from
            which the errors of the initial model are drawn.
    """

    name: str
    reading: str | None = None
    defaults: str = "now"
    nan_policy: str = "raise"
    states_tolerance: bool = False

    def calibrate(self, dataset: Dataset) -> Calibration:
        """Return the calibration of a dataset by this method.

        Raises:
            Undetermined: The data cannot determine the model, or the fit did not converge.
        """
        if self.reading is None:
            from scalar.estimation.calibrate import calibrate

            return calibrate(dataset)
        from scalar.baseline.fit import calibrate_baseline

        # The compressed rows have the sum of squares of all points, and are faster to evaluate.
        return calibrate_baseline(dataset, reading=self.reading, points="compressed", defaults=self.defaults)


METHODS = {
    method.name: method
    for method in (
        Method(PROPOSED),
        Method("baseline-abs", "abs"),
        Method("baseline-abs-2018", "abs", "2018"),
        Method("baseline-clip", "clip"),
        Method("baseline-raise", "raise"),
    )
}
"""``{name: method}``, the methods that a config may name and that figures show."""

EVERY_METHOD = METHODS | {
    method.name: method
    for method in (
        Method(TOLERANCE, states_tolerance=True),
        Method("baseline-nan", "raise", nan_policy="propagate"),
        Method("baseline-nan-2018", "raise", "2018", "propagate"),
    )
}
"""``{name: method}`` of all methods, also of those of single sweeps, and of candidate explanations of the published curves."""
