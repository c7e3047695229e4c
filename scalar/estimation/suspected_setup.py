"""Calibrations with what is suspected of the set-up, which their summaries list."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scalar.data.dataset import Dataset
from scalar.estimation.result import Calibration
from scalar.estimation.setup.plainer_reading import instead, plainer_reading
from scalar.estimation.setup.sensor.earlier_link import EARLIER_LINK
from scalar.estimation.setup.suspicion import Suspicion, WrongSetup


def with_suspicions(calibration: Calibration, suspicions: Sequence[Suspicion]) -> Calibration:
    """Return a calibration with what is suspected of the set-up added to ``setup`` of its summary."""
    entries = [{**suspicion.to_mapping(), "sentence": suspicion.sentence} for suspicion in suspicions]
    summary = calibration.summary
    return replace(calibration, summary={**summary, "setup": [*summary["setup"], *entries]})


def with_plainer_reading(dataset: Dataset, calibrations: Sequence[Calibration]) -> list[Calibration]:
    """Return the calibrations of a dataset; a sign or zero of a joint that explains an implausible fit replaces the suspicions on that fit.

    Args:
        dataset: What was measured.
        calibrations: The rigid one first: it is examined, and what is found holds for all.

    Raises:
        WrongSetup: What is measured is not on the flange, so that lengths which do not move it were fitted.
    """
    first = calibrations[0]
    plainer = plainer_reading(dataset, first.model, first.summary["setup"])
    if not plainer:
        return list(calibrations)
    if any(suspicion.what == EARLIER_LINK for suspicion in plainer):
        raise WrongSetup(plainer)
    return [
        with_suspicions(replace(c, summary={**c.summary, "setup": instead(c.summary["setup"])}), plainer)
        for c in calibrations
    ]
