"""What candidate poses tell of a model, and what of the model decides how well positions are predicted.

Rows are those of the estimator: the whitened Jacobian of the poses with what the sensor would measure there. The arm takes a pose again only
to its repeatability; a shift s of the sensor, of standard deviation r along each axis, is common to a pose, so its rows have the covariance
``I + r^2 W W'`` with W their derivative by s, and are whitened for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.anywhere import random_poses
from scalar.estimation.displacement import displacement_columns
from scalar.estimation.identifiability import analyse
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

N_WORKSPACE = 200  # random poses at which predictions count
_PRIOR_STD = {"m": 0.02, "rad": 0.02}
"""Prior standard deviations, far larger than any error: they keep a design of few poses finite and change no other."""
_OTHER_PRIOR = 1.0


@dataclass(frozen=True, eq=False)
class Information:
    """What candidates tell of F free parameters, in units of their prior standard deviations.

    Attributes:
        rows: ``(N, m, F)``, whitened.
        start: ``(F, F)``, the information of the priors.
        interest: ``(F, F)``: ``trace(interest C)`` is the mean squared error of a predicted position [m^2].
        free: Names of the parameters.
        fixed: Names of those that no pose determines.
        items: ``(N,)``, which item of the target each candidate measures: a plan keeps some of each.
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
    """Return what poses tell of a model.

    Args:
        model: Where it is linearised. Its target is that of ``poses``.
        poses: With what the sensor would measure.
        repeatability: Standard deviation of a pose along each axis [m].
    """
    residuals, model = linearised_at(model, poses)
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


def linearised_at(model: Model, poses: Dataset) -> tuple[Residuals, Model]:
    """Return the residuals of poses, whitened at a model, and the model with the target of these poses."""
    residuals = Residuals.of(poses, model)
    target = residuals.measurement.initial_target(poses)
    model = replace(model, target=target, priors=()).rebased()
    return residuals.reweighted(model), model


def prior_std(model: Model) -> Array:
    """Return the prior standard deviation of every parameter of a model ``(P,)``."""
    return np.array([_PRIOR_STD.get(unit, _OTHER_PRIOR) for unit in model.units])


def whitened_rows(residuals: Residuals, model: Model, repeatability: float) -> Array:
    """Return the Jacobian ``(N, m, P)`` of the measured rows, whitened for the repeatability as well."""
    residual, J = residuals.linearise_measured(model)
    N = len(residuals.poses)
    J = J.reshape(N, len(residual) // N, -1)
    if repeatability > 0:
        W = residuals.wrench(model)[:, :, 3:] * repeatability
        L = np.linalg.cholesky(np.eye(W.shape[1]) + W @ np.swapaxes(W, 1, 2))
        J = np.linalg.solve(L, J)
    return J


def workspace_columns(model: Model) -> Array:
    """Return the derivatives ``(3 K, P)`` of predicted positions at random poses by all parameters, the best motion of the base removed."""
    return displacement_columns(model, random_poses(model, N_WORKSPACE))
