"""Runs that stand in for those of an outer split; other processes import them by their names."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.held_out.repeated_runs import Answer
from scalar.diagnosis.settings import Settings
from scalar.effects.joint_scale import JointScale
from scalar.errors import Undetermined
from scalar.estimation.geometry_fit import geometry_fit


def geometry_alone(dataset: Dataset, settings: Settings) -> Answer:
    """Stand in for a diagnosis that finds nothing."""
    model = geometry_fit(dataset, settings.estimation)[0]
    return Answer(model, model, (), None)


def one_scale(dataset: Dataset, settings: Settings) -> Answer:
    """Stand in for a diagnosis that finds the scale of joint 3."""
    model = geometry_fit(dataset, settings.estimation)[0]
    return Answer(model, model, (JointScale(3),), None)


def corrects_wrongly(dataset: Dataset, settings: Settings) -> Answer:
    """Stand in for a diagnosis whose correction predicts worse than the model without it: that of half of the poses."""
    model, poor = (
        geometry_fit(part, settings.estimation)[0]
        for part in (dataset, dataset.subset(np.arange(dataset.n_poses // 2)))
    )
    return Answer(model, poor, (JointScale(3),), None)


def refuses_the_first(dataset: Dataset, settings: Settings) -> Answer:
    """Stand in for a diagnosis that fails without the first pose."""
    if 1 not in dataset.pose_ids:
        raise Undetermined(["the first pose is missing"])
    return geometry_alone(dataset, settings)
