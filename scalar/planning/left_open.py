"""How far predictions may err within the joint limits by what a diagnosis left open: the error of the found model does not count it.

The error that is expected of a calibration is that of its own parameters. Poses that show little of the joint space also leave open coefficients
of the effects that were found (the torques of other links), what the effects are confounded with, and effects that they do not show at all. Here all
of these are parameters: those of an effect that was found with a prior standard deviation of the size of its coefficients, the others with their
natural size. The rows of the measured poses give the covariance of all parameters, and this the error of a predicted position. The noise is that
of the fit, with what the residual has beyond it: that is how far measured poses scatter, whatever the arm's repeatability is said to be.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects import Effect
from scalar.estimation.displacement import displacement_columns, position_std
from scalar.estimation.misfit import excess_factor
from scalar.estimation.model import Model
from scalar.estimation.random_poses import limits_or_seen, poses_within_limits
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.planning.information import linearised_at, prior_std, whitened_rows
from scalar.planning.questions import Pair, open_pairs, with_whole, with_zero

_N_POSES, _SEED = 500, 20240  # random poses at which predictions count


@dataclass(frozen=True, eq=False)
class LeftOpen:
    """What a diagnosis left open, and how far predictions may err by it.

    Attributes:
        error: Of a predicted position [m], root mean square over random poses within the joint limits, all that was left open included.
        effects: Which effects were left open.
    """

    error: float
    effects: tuple[Effect, ...]


def left_open(dataset: Dataset, calibration: Calibration, diagnosis: Mapping[str, Any]) -> LeftOpen | None:
    """Return how far predictions may err by what a diagnosis left open; None where it left nothing open that acts on the arm.

    Args:
        dataset: That was diagnosed.
        calibration: The one after the diagnosis.
        diagnosis: Content of ``diagnosis.json``.
    """
    pairs, _ = open_pairs(diagnosis, calibration.model.effects, dataset)
    pairs = [pair for pair in pairs if _on_the_arm(pair)]
    if not pairs:
        return None
    base = with_whole(calibration.model.effects, pairs)
    rivals = [pair.effect if pair.rival is None else pair.rival for pair in pairs]
    model = replace(calibration.model, effects=with_zero(base, rivals))
    residuals, here = linearised_at(model, dataset)
    rows = whitened_rows(residuals, here) / excess_factor(calibration.summary)
    prior = _priors(here, calibration)
    free = prior > 0
    scaled = rows[:, :, free].reshape(-1, int(free.sum())) * prior[free]
    covariance = np.linalg.inv(np.eye(scaled.shape[1]) + scaled.T @ scaled)
    limits = limits_or_seen(here.nominal.limits, dataset.q)
    anywhere = poses_within_limits(limits, residuals.poses, _N_POSES, _SEED)
    columns = displacement_columns(here, anywhere)[:, free] * prior[free]
    return LeftOpen(position_std(columns, covariance), tuple(pair.effect for pair in pairs))


def _on_the_arm(pair: Pair) -> bool:
    """Return whether a pair concerns what moves the arm by its joint angles; a wrong range, say, is no matter of where poses lie."""
    effects = (pair.effect,) if pair.rival is None else (pair.effect, pair.rival)
    return all(effect.stays_with_arm and effect.acts_by_joint_angles for effect in effects)


def _priors(model: Model, fitted: Calibration) -> Array:
    """Return the prior standard deviations ``(P,)`` of a model's parameters; zero for a parameter of the arm that was fixed."""
    geometry = set(model.robot.parameter_names) - set(fitted.free)
    prior = np.where(np.isin(model.names, list(geometry)), 0.0, prior_std(model))
    start = model.blocks["effects"].start
    return np.concatenate([prior[:start], *(_sizes(effect) for effect in model.effects)])


def _sizes(effect: Effect) -> Array:
    """Return the size that each coefficient of an effect may have: that of those found, or the natural one."""
    found = effect.coefficients[effect.coefficients != 0]
    if len(found):
        return np.full(len(effect.coefficients), float(np.sqrt(np.mean(found**2))))
    return np.array(effect.natural_sizes, dtype=float)
