"""How far predictions may err within the joint limits because of questions that a diagnosis left open.

The error that a calibration states for its predictions comes from its own parameters alone. Poses that cover little of the joint space leave more
open: further coefficients of the effects that were found (the torques of other links), effects with which these are confounded, and effects that
were unobservable. Here all of these are parameters. The prior standard deviation of a found effect's coefficients is their own root mean square,
that of the others is their natural size. The rows of the measured poses then give the covariance of all parameters, and from it follows the error
of a predicted position. The noise is that of the fit, enlarged by the ratio of the residual to it: this is how far the measured poses do scatter,
and it contains the arm's repeatability.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects import Effect
from scalar.estimation.displacement import displacement_columns, position_std, stretch_of
from scalar.estimation.misfit import excess_factor
from scalar.estimation.model import Model
from scalar.estimation.random_poses import limits_or_measured_ranges, poses_within_limits
from scalar.estimation.result import Calibration
from scalar.estimation.unknown_scale import unknown_scale
from scalar.geometry.se3 import Array
from scalar.planning.information import linearised_at, prior_std, whitened_rows
from scalar.planning.questions import Pair, open_pairs, with_terms_of_pairs, with_zero

_N_POSES, _SEED = 500, 20240  # random poses over which the error of predictions is averaged


@dataclass(frozen=True, eq=False)
class LeftOpen:
    """The effects that a diagnosis left open, and how far predictions may err because of them.

    Attributes:
        error: Standard error of a predicted position [m], root mean square over random poses within the joint limits, with everything that was left
            open among the parameters, and the scale of the arm where no length is known.
        effects: The effects that were left open.
    """

    error: float
    effects: tuple[Effect, ...]


def left_open(dataset: Dataset, calibration: Calibration, diagnosis: Mapping[str, Any]) -> LeftOpen | None:
    """Return how far predictions may err because of what a diagnosis left open; None if it left nothing open that acts on the joint angles.

    Args:
        dataset: The dataset that was diagnosed.
        calibration: The calibration after the diagnosis.
        diagnosis: Content of ``diagnosis.json``.
    """
    pairs, _ = open_pairs(diagnosis, calibration.model.effects, dataset)
    pairs = [pair for pair in pairs if _on_the_arm(pair)]
    if not pairs:
        return None
    base = with_terms_of_pairs(calibration.model.effects, pairs)
    in_question = [pair.effect if pair.rival is None else pair.rival for pair in pairs]
    model = replace(calibration.model, effects=with_zero(base, in_question))
    residuals, model = linearised_at(model, dataset)
    rows = whitened_rows(residuals, model) / excess_factor(calibration.summary)
    prior = _prior_std(model, calibration)
    free = prior > 0
    scaled = rows[:, :, free].reshape(-1, int(free.sum())) * prior[free]
    covariance = np.linalg.inv(np.eye(scaled.shape[1]) + scaled.T @ scaled)
    limits = limits_or_measured_ranges(model.nominal.limits, dataset.q)
    random_poses = poses_within_limits(limits, residuals.poses, _N_POSES, _SEED)
    columns = displacement_columns(model, random_poses)[:, free] * prior[free]
    error = position_std(columns, covariance)
    if (scale := unknown_scale(calibration)) is not None:
        error = float(np.hypot(error, scale.relative * stretch_of(model, random_poses)))
    return LeftOpen(error, tuple(pair.effect for pair in pairs))


def _on_the_arm(pair: Pair) -> bool:
    """Return whether all effects of a pair belong to the arm and depend on its joint angles (an error of the sensor's range does not)."""
    effects = (pair.effect,) if pair.rival is None else (pair.effect, pair.rival)
    return all(effect.stays_with_arm and effect.acts_by_joint_angles for effect in effects)


def _prior_std(model: Model, fitted: Calibration) -> Array:
    """Return the prior standard deviations ``(P,)`` of a model's parameters; zero for a parameter of the arm that was fixed."""
    geometry = set(model.robot.parameter_names) - set(fitted.free)
    prior = np.where(np.isin(model.names, list(geometry)), 0.0, prior_std(model))
    start = model.blocks["effects"].start
    return np.concatenate([prior[:start], *(_sizes(effect) for effect in model.effects)])


def _sizes(effect: Effect) -> Array:
    """Return the size that each coefficient of an effect may have, ``(k,)``: the root mean square of those found, or else the natural size."""
    found = effect.coefficients[effect.coefficients != 0]
    if len(found):
        return np.full(len(effect.coefficients), float(np.sqrt(np.mean(found**2))))
    return np.array(effect.natural_sizes, dtype=float)
