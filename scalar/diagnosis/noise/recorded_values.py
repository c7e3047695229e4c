"""Test whether residuals differ between the values of a recorded column that has few: the loads, the directions of approach, the sessions.

Neighbours in the order of such a column are chosen among equals, so ``autocorrelation`` does not test it. Here the poses with the same value form a
group, and the means of the residual's components are compared between the groups. With a the components and the sign of each pose random, the mean
m_g of group g has the variance ``1 / w_g``, where ``w_g = n_g^2 / sum a_i^2`` over its n_g poses, whatever the sizes of its residuals. The number
``Q = sum w_g (m_g - m)^2``, with m the mean of all m_g with the weights w_g, then has as its mean the number of groups less one, G - 1, and about the
chi-squared distribution with so many degrees of freedom. Sums of random signs have no heavier tails than the normal distribution but for a factor of
about three (Pinelis, Annals of Probability 22, 1994), so that small p-values mean what they say.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from scipy.stats import chi2

from scalar.data.dataset import Dataset
from scalar.data.poses import session_codes
from scalar.diagnosis.settings import DEFAULTS
from scalar.geometry.se3 import Array


def columns_of_few_values(dataset: Dataset, least_poses: int) -> dict[str, Array]:
    """Return the recorded columns whose values divide the poses into groups that can be compared: for each, the group of each pose ``(N,)``, by name.

    Directions of approach and sessions are among them. A column that divides the poses as one before it does is left out.

    Args:
        dataset: The dataset.
        least_poses: A value counts only if at least so many poses have it. A column with more different values is tested in their order instead.
    """
    n = dataset.robot.n_joints
    found: dict[str, Array] = {}
    for name in ("session", *(f"approach{j + 1}" for j in range(n)), "temperature", *dataset.covariates):
        if name not in dataset.poses:
            continue
        labels = cast(Any, dataset.poses[name])
        codes = session_codes(labels) if name == "session" else labels.to_numpy(dtype=float)
        different, groups, counts = np.unique(codes, return_inverse=True, return_counts=True)
        if len(different) > least_poses or np.sum(counts >= least_poses) < 2:
            continue
        if not any(_same_division(groups, other) for other in found.values()):
            found[name] = groups
    return found


def differences_between_groups(
    components: Array, groups: Array, least_poses: int = DEFAULTS.autocorrelation.least_poses
) -> list[float]:
    """Return the p-value of the differences between the means of groups, for each of K components, if the sign of each pose is random.

    Args:
        components: ``(N, K)``, the components of each pose's residual.
        groups: ``(N,)``, integers; poses with the same number are a group. Groups of fewer than ``least_poses`` are left out.
        least_poses: See ``groups``.
    """
    numbers, counts = np.unique(groups, return_counts=True)
    members = [np.flatnonzero(groups == g) for g in numbers[counts >= least_poses]]
    sums = np.array([components[mine].sum(axis=0) for mine in members]).reshape(-1, components.shape[1])
    squares = np.array([np.sum(components[mine] ** 2, axis=0) for mine in members]).reshape(sums.shape)
    if len(members) < 2:
        return [1.0] * components.shape[1]
    sizes = np.array([[float(len(mine))] for mine in members])
    seen = (squares > 0).all(axis=0)
    weights = sizes**2 / np.where(squares > 0, squares, 1.0)
    means = sums / sizes
    centre = np.sum(weights * means, axis=0) / np.sum(weights, axis=0)
    statistic = np.sum(weights * (means - centre) ** 2, axis=0)
    return [float(chance) for chance in np.where(seen, chi2.sf(statistic, len(members) - 1), 1.0)]


def _same_division(groups: Array, others: Array) -> bool:
    """Return whether two columns ``(N,)`` of group numbers, each from 0, divide the poses alike."""
    pairs = len(np.unique(np.column_stack([groups, others]), axis=0))
    return pairs == int(groups.max()) + 1 == int(others.max()) + 1
