"""Whether the remaining residual is noise: where something acts on the arm, the residuals of neighbouring poses are autocorrelated.

A noise of whole poses is drawn anew at every pose. Before it is given a name, what each pose asks for is put in the order of everything that is
recorded, and multiplied by what its neighbours ask for: ``t = sum a_i a_k / sqrt(sum (a_i a_k)^2)`` over neighbours i and k, about normal
where the order means nothing (von Neumann's ratio, with the standard error of the products taken from the products themselves). What a pose asks
for is its residual, target plane by target plane; or its residual along the derivative by one joint's angle, of which the sign is that of the joint's
error on whatever plane.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import KDTree
from scipy.stats import norm, rankdata

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.settings import DEFAULTS, AutocorrelationSettings
from scalar.diagnosis.variance_components import directions
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array

LAGS = (1, 2, 3)


def depends_on(state: FittedState) -> list[str]:
    """Return the columns along which the residuals are autocorrelated beyond chance, the most significant ones; none where they are noise."""
    z, settings = state.background().residual, state.settings.autocorrelation
    along = _along(state, z)
    poses = state.residuals.poses
    plates = state.residuals.measurement.target_index
    whole = np.zeros(len(z))
    moving = [
        j
        for j in range(poses.q.shape[1])
        if np.ptp(poses.q[:, j]) > state.settings.estimation.identifiability.still
    ]
    angles = {f"q{j + 1}": poses.q[:, j] for j in moving}
    chances: dict[tuple[str, ...], float] = {}
    for name, values in (angles | _courses(state) | _places(state)).items():
        near = _in_order(whole, values, settings.least_poses)
        tried = [
            alike(z, _in_order(plates, values, settings.least_poses)),
            *(alike(a[:, None], near) for a in along),
        ]
        chances[name,] = min(tried) * len(tried)
    for pair in itertools.combinations(angles, 2):
        near = _near(np.column_stack([angles[name] for name in pair]), settings)
        chances[pair] = min(alike(a[:, None], near) for a in along) * len(along)
    surest = min(chances, key=lambda names: chances[names])
    return list(surest) if chances[surest] * len(chances) < settings.alpha_autocorrelation else []


def alike(z: Array, near: Array) -> float:
    """Return the chance that neighbours are as much alike as these where to be neighbours means nothing.

    Args:
        z: ``(N, m)``, residuals.
        near: ``(P, 2)``, pairs of neighbours.
    """
    products = np.sum(z[near[:, 0]] * z[near[:, 1]], axis=1)
    length = float(np.sqrt(np.sum(products**2)))
    return float(norm.sf(products.sum() / length)) if length > 0 else 1.0


def _in_order(groups: Array, order: Array, least_poses: int = DEFAULTS.autocorrelation.least_poses) -> Array:
    """Return the neighbours ``(P, 2)`` in an order ``(N,)`` within each group ``(N,)``."""
    pairs = [np.zeros((0, 2), dtype=int)]
    for group in np.unique(groups):
        mine = np.flatnonzero(groups == group)
        if len(mine) >= least_poses:
            mine = mine[np.argsort(order[mine], kind="stable")]
            pairs += [np.column_stack([mine[lag:], mine[:-lag]]) for lag in LAGS]
    return np.concatenate(pairs)


def _near(values: Array, settings: AutocorrelationSettings = DEFAULTS.autocorrelation) -> Array:
    """Return the neighbours ``(P, 2)`` in two variables ``(N, 2)``, each by its rank; every pair once."""
    if len(values) < settings.least_poses:
        return np.zeros((0, 2), dtype=int)
    ranks = rankdata(values, axis=0)
    found = np.asarray(KDTree(ranks).query(ranks, k=settings.neighbours + 1)[1])[:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(len(values)), settings.neighbours), found.ravel()])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _along(state: FittedState, z: Array) -> list[Array]:
    """Return what each pose asks of every joint's angle ``(N,)``, in standard errors."""
    by_angle = dict(directions(state.residuals, state.model))["pose_jitter"]
    if state.whitening is not None:
        by_angle = state.whitening @ by_angle
    lengths = np.linalg.norm(by_angle, axis=1)
    asked = np.einsum("nmk,nm->nk", by_angle, z) / np.maximum(lengths, 1e-300)
    return list(asked[:, lengths.any(axis=0)].T)


def _courses(state: FittedState) -> dict[str, Array]:
    """Return the order of acquisition and every column that was recorded with the poses."""
    dataset = state.dataset
    found = {"time" if "time" in dataset.poses else "order": state.residuals.poses.order}
    for name in ("temperature", *dataset.covariates):
        if (
            name in dataset.poses
            and len(np.unique(dataset.poses[name].to_numpy())) > state.settings.autocorrelation.least_poses
        ):
            found[name] = dataset.poses[name].to_numpy(dtype=float)
    return found


def _places(state: FittedState) -> dict[str, Array]:
    """Return where on its target plane the sensor looked, along the plane's own two axes [m], ``(N,)`` each; nothing for a tracker."""
    target = state.model.target
    if not isinstance(target, Planes):
        return {}
    origins = state.residuals.kinematics(state.model).T_base_sensor[:, :3, 3]
    along = np.einsum("nkx,nx->kn", target.tangents[state.residuals.measurement.target_index], origins)
    return {"plate_u": along[0], "plate_v": along[1]}
