"""Test whether the remaining residual is noise: if something unmodelled acts on the arm, residuals of neighbouring poses are correlated.

A variance component of whole poses is drawn anew at every pose. Before one is reported, the poses are sorted by every quantity that is known of
them, and the residuals a of neighbours i and k in that order are multiplied: ``t = sum a_i a_k / sqrt(sum (a_i a_k)^2)`` is about normal if the
order has no influence (von Neumann's ratio, with the standard error of the products taken from the products themselves). Two kinds of a are
tested. One is the residual itself, with neighbours on the same target plane. The other is the component of the residual along its derivative by a
quantity that might err (``components_along``); its sign is that of the error, whichever plane was measured. The poses are sorted by time, by recorded
columns, by angles, by sums and differences of two angles, by the place on the plane and by the direction of gravity in the sensor's frame.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import KDTree
from scipy.stats import norm, rankdata

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.settings import DEFAULTS, AutocorrelationSettings
from scalar.diagnosis.sign_flips import upper_tail
from scalar.effects.flexible.variable import GRAVITY
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array

LAGS = (1, 2, 3)
_NORMAL_SUFFICES = 0.01  # a p-value above it is taken from the normal distribution


def depends_on(state: FittedState) -> list[str]:
    """Return the columns along which the residuals are most significantly autocorrelated; an empty list if no autocorrelation is significant."""
    found = autocorrelation_p_values(state, state.background().residual)
    surest = min(found, key=lambda names: found[names])
    return list(surest) if found[surest] < state.settings.autocorrelation.alpha_autocorrelation else []


def autocorrelation_p_values(state: FittedState, z: Array) -> dict[tuple[str, ...], float]:
    """Return the p-value of the autocorrelation along each set of columns, corrected for the number of sets.

    The sets form three families: recorded quantities that vary in the course of time, single columns, and pairs of angles. Each family
    has a third of the significance level (weighted Bonferroni), so that the many pairs of angles do not hide a dependence on time.

    Args:
        state: Whose model is at its optimum.
        z: ``(N, m)``, its whitened residuals, or a draw of what they would be by chance.
    """
    least = state.settings.autocorrelation.least_poses
    components = components_along(state, z)
    planes = state.residuals.measurement.target_index
    one_group = np.zeros(len(z))
    angles, in_time = _moving_angles(state), _recorded_in_time(state)
    found: dict[str, list[tuple[tuple[str, ...], float]]] = {"in_time": [], "single": [], "pair": []}

    def judge(family: str, names: tuple[str, ...], tried: list[float]) -> None:
        found[family].append((names, min(tried, default=1.0) * len(tried)))

    def in_order(values: Array) -> list[float]:
        by_plane = neighbour_p_value(z, _in_order(planes, values, least))
        return [by_plane, *neighbour_p_values(components, _in_order(one_group, values, least))]

    for name, values in in_time.items():
        judge("in_time", (name,), in_order(values))
    for name, values in (angles | _places(state)).items():
        judge("single", (name,), in_order(values))
    for component in _gravity(state):
        judge("single", (GRAVITY,), in_order(component))
    for a, b in itertools.combinations(angles, 2):
        judge("pair", (a, b), in_order(angles[a] + angles[b]))
        judge("pair", (a, b), in_order(angles[a] - angles[b]))
        near = _near(np.column_stack([angles[a], angles[b]]), state.settings.autocorrelation)
        judge("pair", (a, b), neighbour_p_values(components, near))
    corrected: dict[tuple[str, ...], float] = {}
    for family in found.values():
        for names, chance in family:
            corrected[names] = min(corrected.get(names, np.inf), chance * len(family) * len(found))
    return corrected


def _moving_angles(state: FittedState) -> dict[str, Array]:
    """Return the angles ``(N,)`` [rad] of the joints that move, by name."""
    q, still = state.residuals.poses.q, state.settings.estimation.identifiability.still
    return {f"q{j + 1}": q[:, j] for j in range(q.shape[1]) if np.ptp(q[:, j]) > still}


def neighbour_p_value(z: Array, near: Array) -> float:
    """Return the p-value of the correlation of residuals between neighbours.

    Args:
        z: ``(N, m)``, residuals.
        near: ``(P, 2)``, pairs of neighbours.
    """
    products = np.sum(z[near[:, 0]] * z[near[:, 1]], axis=1)
    return _p_values(products[:, None], near, len(z))[0]


def neighbour_p_values(components: Array, near: Array) -> list[float]:
    """Return the same p-value for each column of ``components`` ``(N, K)``."""
    return _p_values(components[near[:, 0]] * components[near[:, 1]], near, len(components))


def _p_values(products: Array, near: Array, n_poses: int) -> list[float]:
    """Return the p-value of each sum of products ``(P, K)`` over neighbours ``(P, 2)``, where the sign of each pose is random.

    A p-value that is small by the normal distribution is computed again from the distribution of the sum itself, whose tail is heavier
    if a few poses have large residuals.
    """
    sums, lengths = products.sum(axis=0), np.sqrt(np.sum(products**2, axis=0))
    seen = lengths > 0
    found = np.where(seen, norm.sf(sums / np.where(seen, lengths, 1.0)), 1.0)
    for k in np.flatnonzero(found < _NORMAL_SUFFICES):
        found[k] = upper_tail(products[:, k], near, n_poses)
    return [float(chance) for chance in found]


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
    """Return the neighbours ``(P, 2)`` in two variables ``(N, 2)``, each by its rank, as many as in an order; every pair once."""
    if len(values) < settings.least_poses:
        return np.zeros((0, 2), dtype=int)
    ranks = rankdata(values, axis=0)
    found = np.asarray(KDTree(ranks).query(ranks, k=len(LAGS) + 1)[1])[:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(len(values)), len(LAGS)), found.ravel()])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def components_along(state: FittedState, z: Array) -> Array:
    """Return the component of each pose's residual along its derivative by each quantity that might err ``(N, K)``, in standard errors.

    The quantities are every joint's angle, all lengths in proportion (growth), and the components of the sensor's pose on the flange and of
    the base's pose. A quantity that no row depends on is left out.

    Args:
        state: Whose model is at its optimum.
        z: ``(N, m)``, whitened residuals.
    """
    N, m = z.shape
    model, n = state.model, state.model.robot.n_joints
    jacobian = state.residuals.linearise_measured(model)[1]
    geometry = jacobian[:, model.blocks["geometry"]].reshape(N, m, len(GEOMETRY), n)
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    growth = np.sum(geometry[:, :, lengths] * model.nominal.geometry[lengths], axis=(2, 3))
    by_joint = geometry.reshape(N, m, -1)[:, :, model.robot.joint_columns]
    sensor = jacobian[:, model.blocks["sensor"]].reshape(N, m, -1)
    base = state.residuals.wrench(model)
    by_place = np.concatenate([by_joint, growth[:, :, None], sensor, base], axis=2)
    if state.whitening is not None:
        by_place = state.whitening @ by_place
    sizes = np.linalg.norm(by_place, axis=1)
    components = np.einsum("nmk,nm->nk", by_place, z) / np.maximum(sizes, 1e-300)
    return components[:, sizes.any(axis=0)]


def _recorded_in_time(state: FittedState) -> dict[str, Array]:
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
    return {"plane_u": along[0], "plane_v": along[1]}


def _gravity(state: FittedState) -> Array:
    """Return the direction of gravity in the sensor's frame ``(3, N)``; nothing where it is not stated."""
    down = state.model.robot.down
    if not down.any():
        return np.zeros((0, state.dataset.n_poses))
    rotations = state.residuals.kinematics(state.model).T_base_sensor[:, :3, :3]
    return np.einsum("nij,i->jn", rotations, down)
