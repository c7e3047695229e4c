"""The Fisher information that candidate poses give on the parameters of a model, and the error of predicted positions that it leaves.

The rows of a pose are those of the estimator: the whitened Jacobian of what the sensor would measure there. An arm returns to a pose only within
its repeatability. All measurements of a pose therefore share a random shift s of the sensor, of standard deviation r along each axis. The whitened
rows then have the covariance ``I + r^2 W W'`` with W their derivative by s, and are whitened once more for that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.displacement import displacement_columns
from scalar.estimation.identifiability import analyse
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask
from scalar.estimation.random_poses import random_poses
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

N_WORKSPACE = 200  # random poses over which the error of predicted positions is averaged
_PRIOR_STD = {"m": 0.02, "rad": 0.02}
"""Prior standard deviations by unit, far larger than any error: they keep the covariance of few poses finite, and hardly change that of many."""
_OTHER_PRIOR = 1.0  # prior standard deviation of a parameter in any other unit


@dataclass(frozen=True, eq=False)
class Information:
    """The information of N candidates on F free parameters, each in units of its prior standard deviation.

    The covariance after measuring some candidates is ``inv(start + A' A)``, with A their rows.

    Attributes:
        rows: ``(N, m, F)``, whitened rows of the candidates.
        start: ``(F, F)``, the information of the priors: the identity in these units.
        interest: ``(F, F)``: ``trace(interest C)`` is the mean squared error of a predicted position [m^2] if the parameters have the covariance C.
        free: Names of the free parameters.
        fixed: Names of the parameters that all candidates together do not determine.
        items: ``(N,)``, the index of the plane, or of the tracker's session, that each candidate measures: a plan contains some of each.
    """

    rows: Array
    start: Array
    interest: Array
    free: tuple[str, ...]
    fixed: tuple[str, ...]
    items: Array

    def error(self, covariance: Array) -> float:
        """Return the expected error of a predicted position [m], root mean square over the workspace."""
        return float(np.sqrt(np.sum(self.interest * covariance)))


def information(model: Model, poses: Dataset, repeatability: float) -> Information:
    """Return the information of poses on the parameters of a model, of which those that all poses together do not determine are fixed.

    Args:
        model: The model at which the measurements are linearised; its target is replaced by that of ``poses``.
        poses: Poses with what the sensor would measure there.
        repeatability: Standard deviation along each axis with which the arm takes a pose again [m].
    """
    residuals, model = linearised_at(model, poses, measured=False)
    mask = candidate_mask(replace(model, effects=()))
    fixed = analyse(residuals, model, mask).fixed_names
    n_effects = len(model.names) - len(mask)
    free = np.r_[mask & ~np.isin(model.names[: len(mask)], fixed), np.ones(n_effects, dtype=bool)]
    prior = prior_std(model)[free]
    rows = whitened_rows(residuals, model, repeatability)[:, :, free] * prior
    columns = workspace_columns(model)[:, free] * prior
    names = tuple(name for name, wanted in zip(model.names, free, strict=True) if wanted)
    return Information(
        rows,
        np.eye(len(prior)),
        columns.T @ columns / N_WORKSPACE,
        names,
        fixed,
        residuals.measurement.target_index,
    )


def linearised_at(model: Model, poses: Dataset, *, measured: bool = True) -> tuple[Residuals, Model]:
    """Return the residuals of poses, whitened at a model, and the model with the target of these poses.

    Args:
        model: The model.
        poses: Poses with what was measured there, or with what the sensor would measure.
        measured: False if nothing was measured. The residuals are then zero by construction, so the noise is not estimated from them, but taken as
            stated.
    """
    residuals = Residuals.of(poses, model)
    if not measured:
        residuals = replace(residuals, measurement=residuals.measurement.weighted_like(residuals.measurement))
    target = residuals.measurement.initial_target(poses)
    if measured:  # a noise that is not stated is estimated from the residual, which is that of the noise only at the fitted target
        target = residuals.measurement.fitted_target(residuals.kinematics(model).T_base_sensor, target)
    model = replace(model, target=target, priors=()).rebased()
    return residuals.reweighted(model), model


def prior_std(model: Model) -> Array:
    """Return the weak prior standard deviation of every parameter of a model, ``(P,)`` in its unit."""
    return np.array([_PRIOR_STD.get(unit, _OTHER_PRIOR) for unit in model.units])


def whitened_rows(residuals: Residuals, model: Model, repeatability: float = 0.0) -> Array:
    """Return the Jacobian ``(N, m, P)`` of the measurements, whitened for the sensor's noise and the arm's repeatability [m]."""
    residual, J = residuals.linearise_measured(model)
    N = len(residuals.poses)
    J = J.reshape(N, len(residual) // N, -1)
    if repeatability > 0:
        W = (
            residuals.wrench(model)[:, :, 3:] * repeatability
        )  # r times the derivatives by the shift, the last three of the screw
        L = np.linalg.cholesky(np.eye(W.shape[1]) + W @ np.swapaxes(W, 1, 2))
        J = np.linalg.solve(L, J)
    return J


def workspace_columns(model: Model) -> Array:
    """Return the derivatives ``(3 K, P)`` of predicted positions [m] at K random poses by all parameters, as ``displacement_columns`` does."""
    return displacement_columns(model, random_poses(model, N_WORKSPACE))
