"""Words on the residual of a calibration: what of it counts, and the few poses that lie far from the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.misfit import lacks_something
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.report.words import length, listed

_FAR = 10.0  # chosen: a pose lies far from the model if its distance is more than this many times the median; normal noise never makes it
_FEW = 0.05  # chosen: poses are named if no larger share of all lies far; otherwise the model is wrong, and not a few poses
_SHOWN = 5  # poses that are named one by one


def residual_in_words(summary: Mapping[str, Any]) -> str:
    """Return what is compared with the noise: the residual, without the scatter within poses where a pose has several points."""
    several = summary["points"] > summary["poses"]
    return "apart from the scatter within poses, the residual" if several else "the residual"


def far_poses(calibration: Calibration, dataset: Dataset) -> list[str]:
    """Return one sentence that names a few poses that lie far from the model, none if there are none or many.

    Args:
        calibration: The calibration.
        dataset: The dataset from which it was estimated.
    """
    if not lacks_something(calibration.summary):
        return []
    distances = Residuals.of(dataset, calibration.model).pose_distances(calibration.model)
    median = float(np.median(distances))
    far = np.flatnonzero(distances > _FAR * median)
    far = far[np.argsort(-distances[far])]
    if not 0 < len(far) <= max(1, _FEW * len(distances)):
        return []
    named = [f"pose {dataset.pose_ids[i]} by {length(float(distances[i]))}" for i in far[:_SHOWN]]
    more = [f"{len(far) - _SHOWN} more"] if len(far) > _SHOWN else []
    return [
        f"Far from the model, where half of the poses are within {length(median)}: {listed([*named, *more])}. Check what was recorded there; "
        "'scalar diagnose' sets gross errors aside, and 'scalar calibrate' does not."
    ]
