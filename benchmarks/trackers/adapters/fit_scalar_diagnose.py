"""Diagnose with ``scalar.diagnose``, and predict with the calibration that it ships: the geometry and the effects that it found."""

from __future__ import annotations

from dataclasses import replace

from exchange import Fitted, Job, run
from fit_scalar import dataset_of, fitted

from scalar import diagnose


def fit(job: Job) -> Fitted:
    """Return the calibration that the diagnosis of a job ships; what it took is unknown, as many models were fitted before."""
    return replace(fitted(diagnose(dataset_of(job)).calibration_after), evaluations=None)


if __name__ == "__main__":
    run("scalar-calibration", fit)
