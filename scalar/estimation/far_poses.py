"""Find a few poses that lie far from where all the others say they should be.

With few poses, a single gross error does not stand out in the residual: the parameters adapt to it, and its error spreads over all poses. Each pose
is therefore compared with the fit to the others (the deletion residual; Cook and Weisberg, Residuals and Influence in Regression, 1982, chapter 2),
and the poses that raise the residual most are left out one after the other.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import f as f_distribution

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import deletion_residuals
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array

_FAR = 10.0  # chosen: a pose lies far from the model if its distance is more than this many times the median; normal noise never makes it
_FEW = 0.05  # chosen: poses are named if no larger share of all lies far; otherwise the model is wrong, and not a few poses
_LINEARISATIONS = 3  # about the fit to all, and twice about the fit to the others: an error of centimetres bends the fit to all
_BY_CHANCE = 1e-3  # chosen: probability that any pose of a dataset without gross errors is left out


def far_poses(calibration: Calibration, dataset: Dataset) -> tuple[list[tuple[int, float]], float]:
    """Return the few poses that lie far from the fit to the others, and the median distance of these others.

    Args:
        calibration: The calibration.
        dataset: The dataset from which it was estimated.

    Returns:
        For each such pose its row and its distance [m], the farthest first, none if there are none or many; and the median distance [m].
    """
    residuals = Residuals.of(dataset, calibration.model)
    free = np.isin(calibration.model.names, calibration.free)
    model, left_out = calibration.model, list[int]()
    for _ in range(_LINEARISATIONS):
        left_out, step = _left_out(residuals, model, free)
        vector = model.vector.copy()
        vector[free] += step
        model = model.with_vector(vector)
    distances = residuals.pose_distances(model)
    median = float(np.median(np.delete(distances, left_out)))
    far = [i for i in left_out if distances[i] > _FAR * median]
    if len(far) > _most_named(dataset.n_poses):
        return [], median
    return sorted(((i, float(distances[i])) for i in far), key=lambda one: -one[1]), median


def _left_out(residuals: Residuals, model: Model, free: Array) -> tuple[list[int], Array]:
    """Return the rows of the poses that do not agree with the fit to the others, and the step ``(F,)`` from a model to that fit.

    One pose more than the few that may be named is looked for, so that many are noticed.

    Args:
        residuals: Of all N poses.
        model: About which all is linearised.
        free: ``(P,)`` bool, the F free parameters.
    """
    equations, m = residuals.measurement.equations, residuals.measurement.rows_per_pose
    N, most = len(equations), _most_named(len(equations)) + 1
    residual, jacobian = residuals.reweighted(model).linearise(model)
    scale = np.maximum(np.linalg.norm(jacobian[:, free], axis=0), np.finfo(float).tiny)
    J = jacobian[:, free] / scale
    n_priors = len(J) - N * m
    rows, among, left_out = J[: N * m].reshape(N, m, -1), np.ones(N, dtype=bool), list[int]()
    while True:
        used = np.r_[np.repeat(among, m), np.ones(n_priors, dtype=bool)]
        inverse = np.linalg.pinv(J[used].T @ J[used], rcond=1e-12, hermitian=True)
        step = -inverse @ (J[used].T @ residual[used])
        rest = residual + J @ step
        own = rest[: N * m].reshape(N, m)
        leverages = np.where(among[:, None, None], rows @ inverse @ np.swapaxes(rows, 1, 2), 0.0)
        # By how much the sum of squares falls without each pose.
        drops = np.where(among, np.sum(own * deletion_residuals(leverages, own), axis=1), 0.0)
        worst = int(np.argmax(drops))
        freedom = int(equations[among].sum()) + n_priors - J.shape[1] - int(equations[worst])
        if freedom < 1 or len(left_out) == most:
            break
        others = max(float(rest[used] @ rest[used]) - drops[worst], np.finfo(float).tiny)
        ratio = drops[worst] / equations[worst] / (others / freedom)
        if f_distribution.sf(ratio, equations[worst], freedom) > _BY_CHANCE / N:
            break
        left_out.append(worst)
        among[worst] = False
    return left_out, step / scale


def _most_named(n_poses: int) -> int:
    """Return how many poses may lie far off; if more do, the model is wrong, and not a few poses."""
    return int(max(1, _FEW * n_poses))
