"""Words on the residual of a calibration: what of it counts, and the few poses that lie far from the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scalar.data.dataset import Dataset
from scalar.estimation.far_poses import far_poses
from scalar.estimation.misfit import lacks_something
from scalar.estimation.result import Calibration
from scalar.report.words import length, listed

_SHOWN = 5  # poses that are named one by one


def residual_in_words(summary: Mapping[str, Any]) -> str:
    """Return what is compared with the noise: the residual, without the scatter within poses where a pose has several points."""
    several = summary["points"] > summary["poses"]
    return (
        "apart from the scatter of the points within each pose, the residual" if several else "the residual"
    )


def far_poses_in_words(calibration: Calibration, dataset: Dataset) -> list[str]:
    """Return one sentence that names a few poses that lie far from the fit to the others, none if there are none or many.

    Args:
        calibration: The calibration.
        dataset: The dataset from which it was estimated.
    """
    if not lacks_something(calibration.summary):
        return []
    far, median = far_poses(calibration, dataset)
    if not far:
        return []
    named = [f"pose {dataset.pose_ids[i]} by {length(distance)}" for i, distance in far[:_SHOWN]]
    more = [f"{len(far) - _SHOWN} more"] if len(far) > _SHOWN else []
    return [
        f"Far from the fit to the other poses, half of which lie within {length(median)} of it: {listed([*named, *more])}. Check what was recorded "
        "there; 'scalar diagnose' sets gross errors aside, and 'scalar calibrate' does not."
    ]
