"""The coordinates in which a calibration is reported, and what it keeps of a dataset's sensor."""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model


def reporting(model: Model, guess: Any) -> Model:
    """Return the model in the coordinates that are reported: absolute rotation vectors, normals relative to those of the initial guess."""
    return Model(
        model.robot,
        model.nominal,
        np.eye(3),
        np.r_[model.sensor[:3], model.sensor_rotation_vector()],
        model.target.expressed_about(guess),
        model.effects,
        model.priors,
        model.misfit_ratio,
    )


def sensor_mapping(dataset: Dataset) -> dict[str, Any]:
    """Return what a calibration keeps of a dataset's sensor."""
    return {key: getattr(dataset.sensor, key) for key in ("kind", "noise", "error_axis")}
