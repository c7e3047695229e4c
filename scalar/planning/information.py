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
        start: ``(F, F)``, the information without any candidate: that of the priors, the identity in these units, and that of measured poses.
        interest: ``(F, F)``: ``trace(interest C)`` is the mean squared error of a predicted position [m^2] if the parameters have the covariance C.
        free: Names of the free parameters.
        fixed: Names of the parameters that all candidates together do not determine.
        items: ``(N,)``, the index of the plane, or of the tracker's session, that each candidate measures: a plan contains some of each.
        measured: How many poses were measured before, whose information ``start`` contains.
        shared: How many of the free parameters these poses share; the others are of a target that only the candidates measure.
    """

    rows: Array
    start: Array
    interest: Array
    free: tuple[str, ...]
    fixed: tuple[str, ...]
    items: Array
    measured: int = 0
    shared: int = 0

    def alone(self) -> Information:
        """Return the information of the candidates without that of measured poses."""
        return replace(self, start=np.eye(len(self.start)), measured=0, shared=0)

    def error(self, covariance: Array) -> float:
        """Return the expected error of a predicted position [m], root mean square over the workspace."""
        return float(np.sqrt(np.sum(self.interest * covariance)))


def information(
    model: Model, poses: Dataset, repeatability: float, measured: Dataset | None = None
) -> Information:
    """Return the information of poses on the parameters of a model, of which those that all poses together do not determine are fixed.

    Args:
        model: The model at which the measurements are linearised; its target is replaced by that of ``poses``.
        poses: Poses with what the sensor would measure there.
        repeatability: Standard deviation along each axis with which the arm takes a pose again [m].
        measured: Poses that were measured before, of the same sensor; their information is added to that of the priors. Parameters are
            shared by their names: a tracker or planes of another session have parameters of their own, which are eliminated.
    """
    residuals, near = linearised_at(model, poses, measured=False)
    mask = candidate_mask(replace(near, effects=()))
    fixed = analyse(residuals, near, mask).fixed_names
    n_effects = len(near.names) - len(mask)
    free = np.r_[mask & ~np.isin(near.names[: len(mask)], fixed), np.ones(n_effects, dtype=bool)]
    prior = prior_std(near)[free]
    rows = whitened_rows(residuals, near, repeatability)[:, :, free] * prior
    columns = workspace_columns(near)[:, free] * prior
    names = tuple(name for name, wanted in zip(near.names, free, strict=True) if wanted)
    found = Information(
        rows,
        np.eye(len(prior)),
        columns.T @ columns / N_WORKSPACE,
        names,
        fixed,
        residuals.measurement.target_index,
    )
    if measured is None:
        return found
    known, shared = _information_of_measured(model, measured, repeatability, names, {*near.names} - {*names})
    return replace(found, start=found.start + known, measured=measured.n_poses, shared=int(shared.sum()))


def _information_of_measured(
    model: Model, measured: Dataset, repeatability: float, names: tuple[str, ...], fixed: set[str]
) -> tuple[Array, Array]:
    """Return the information ``(F, F)`` of measured poses on parameters in units of their priors, and which of them they have ``(F,)`` bool.

    Parameters that these poses have besides (targets of other sessions, further targets on the flange) are eliminated with weak priors.

    Args:
        model: The model.
        measured: The poses.
        repeatability: As in ``information``.
        names: The F parameters.
        fixed: Names of parameters that are fixed.
    """
    residuals, near = linearised_at(model, measured)
    rows = whitened_rows(residuals, near, repeatability) * prior_std(near)
    rows = rows.reshape(-1, rows.shape[2])
    own = [i for i, name in enumerate(near.names) if name not in fixed and name not in names]
    at = {name: i for i, name in enumerate(near.names)}
    shared = np.array([name in at for name in names])
    J = np.zeros((len(rows), len(names)))
    J[:, shared] = rows[:, [at[name] for name in names if name in at]]
    E = rows[:, own]
    cross = E.T @ J
    return J.T @ J - cross.T @ np.linalg.solve(np.eye(len(own)) + E.T @ E, cross), shared


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
        # R times the derivatives by the shift, which are the last three of the screw.
        W = residuals.wrench(model)[:, :, 3:] * repeatability
        L = np.linalg.cholesky(np.eye(W.shape[1]) + W @ np.swapaxes(W, 1, 2))
        J = np.linalg.solve(L, J)
    return J


def workspace_columns(model: Model) -> Array:
    """Return the derivatives ``(3 K, P)`` of predicted positions [m] at K random poses by all parameters, as ``displacement_columns`` does."""
    return displacement_columns(model, random_poses(model, N_WORKSPACE))
