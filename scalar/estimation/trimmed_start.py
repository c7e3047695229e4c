"""The place of a scanner on the flange from poses of which some are labelled with the wrong plane, where dataset.yaml states no nominal pose.

A linear guess from all poses is least squares, and a few wrong labels can lead it to another assignment of the planes. Guesses are therefore made
from small random sets of poses, and the one is taken under which most poses of each plane lie on it: a least quantile of distances, with
random sets as in RANSAC (Fischler and Bolles, 1981).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.initial_estimate import estimate_initially, proposals
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import best_fitting, pose_distances
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import GrossErrorSettings
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import measure

_DRAWS = 60
_OF_EACH_PLANE = 6
"""Poses of each plane in a draw. Two equations each, for the nine unknowns of a linear guess from one plane; with more, fewer draws are free of
wrong labels: with a tenth of wrong labels, one draw in seven."""
_SEED = 0


def with_estimated_pose(dataset: Dataset, usable: Array, settings: GrossErrorSettings) -> Dataset | None:
    """Return the dataset with a nominal pose of the sensor that most poses of each plane agree with; None if no guess can be made.

    Args:
        dataset: What was measured on planes, without a nominal pose.
        usable: ``(N,)`` bool, the poses to use.
        settings: Thresholds.
    """
    measurement = measure(dataset)
    T_base_flange = dataset.robot.flange(dataset.q)
    index = measurement.target_index
    rng = np.random.default_rng(_SEED)
    best, least = None, np.inf
    for _ in range(_DRAWS):
        rows = np.sort(_drawn(index, usable, rng))
        drawn = dataset.subset(rows)
        part = measure(drawn)
        guess = part.initial_target(drawn)
        try:
            starts = proposals(part, dataset.robot, drawn.q, guess, None)
        except Undetermined:
            continue
        for _, T, target in starts:
            distance = _distances(measurement, T_base_flange @ T, target, index)
            score = _score(distance, index, usable, settings)
            if score < least:
                best, least = distance, score
    if best is None:
        return None
    # The arm is nominal and the draw small: the place is estimated again from all poses that agree best.
    core = dataset.subset(best_fitting(dataset, best, usable, settings))
    guess = measure(core).initial_target(core)
    try:
        found = estimate_initially(
            Residuals.of(core, Model.at(core.robot, np.eye(4), guess)), core.robot, guess, None
        )
    except Undetermined:
        return None
    return replace(dataset, sensor=replace(dataset.sensor, T_flange_sensor=found.model.T_flange_sensor))


def _drawn(index: Array, usable: Array, rng: np.random.Generator) -> Array:
    rows = [np.flatnonzero((index == k) & usable) for k in np.unique(index)]
    return np.concatenate([rng.permutation(mine)[:_OF_EACH_PLANE] for mine in rows])


def _distances(measurement: object, T: Array, target: object, index: Array) -> Array:
    assert isinstance(target, Planes)
    return pose_distances(measurement, T, target, index)  # type: ignore[arg-type]


def _score(distance: Array, index: Array, usable: Array, settings: GrossErrorSettings) -> float:
    """Return the largest, over the planes, of the distances that the trusted share of a plane's poses keeps [m]."""
    return max(
        float(np.quantile(distance[(index == k) & usable], settings.core_share))
        for k in np.unique(index[usable])
    )
