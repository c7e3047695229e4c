"""Test whether the remaining residual is noise: if something unmodelled acts on the arm, residuals of neighbouring poses are correlated.

The error that a variance component describes is independent from pose to pose. Before a variance component is reported, the poses are therefore
sorted by every quantity that is known of them, and the residuals a of neighbours i and k in that order are multiplied. The number
``t = sum a_i a_k / sqrt(sum (a_i a_k)^2)`` is about normal if the order has no influence (von Neumann's ratio, with the standard error of the
products taken from the products themselves). Two kinds of a are tested. One is the residual itself, with neighbours on the same target plane. The
other is the component of the residual along its derivative by a quantity that might err (``components_along``); its sign is that of the error,
whichever plane was measured. The poses are sorted by time, by recorded columns, by angles, by sums and differences of two angles, by the place on the
plane and by the direction of gravity in the sensor's frame. For two angles, the poses that are nearest to each other in both are neighbours as well.
A recorded column with few different values has no such order; there, the means of the components are compared (``recorded_values``).
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import KDTree
from scipy.special import ndtr
from scipy.stats import rankdata

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import NO_DERIVATIVE
from scalar.diagnosis.noise.recorded_values import columns_of_few_values, differences_between_groups
from scalar.diagnosis.noise.sign_flips import upper_tail
from scalar.diagnosis.settings import DEFAULTS, AutocorrelationSettings
from scalar.effects.flexible.variable import GRAVITY
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array

LAGS = (1, 2, 3)  # poses that are so many places apart in an order are neighbours
_NORMAL_SUFFICES = 0.01  # a larger p-value is taken from the normal distribution


def depends_on(state: FittedState) -> list[str]:
    """Return the columns along which the residuals are most significantly autocorrelated; an empty list if no autocorrelation is significant."""
    found = autocorrelation_p_values(state, state.background().residual)
    return most_significant(found, state.settings.autocorrelation)


def most_significant(p_values: dict[tuple[str, ...], float], settings: AutocorrelationSettings) -> list[str]:
    """Return the columns with the smallest of the p-values of ``autocorrelation_p_values``; an empty list if it is not significant."""
    names = min(p_values, key=lambda names: p_values[names], default=())
    return list(names) if names and p_values[names] < settings.alpha_autocorrelation else []


def autocorrelation_p_values(state: FittedState, z: Array) -> dict[tuple[str, ...], float]:
    """Return the p-value of the autocorrelation along each set of columns, corrected for the number of tests.

    The sets form families: time and columns recorded with the poses, other single quantities, pairs of angles, and, if there are any, columns with
    few different values. Each family has an equal part of the significance level (weighted Bonferroni), so that the many pairs of angles do not
    hide a dependence on time.

    Args:
        state: The fitted state.
        z: ``(N, m)``, its whitened residuals, or random numbers in their place.
    """
    least = state.settings.autocorrelation.least_poses
    components = components_along(state, z)
    planes = state.residuals.measurement.target_index
    one_group = np.zeros(len(z))
    angles, in_time = _moving_angles(state), _recorded_in_time(state)
    found: dict[str, list[tuple[tuple[str, ...], float]]] = {"in_time": [], "single": [], "pair": []}

    def add(family: str, names: tuple[str, ...], p_values: list[float]) -> None:
        """Add the smallest of the p-values of one order, corrected for their number."""
        found[family].append((names, min(p_values, default=1.0) * len(p_values)))

    def in_order(values: Array) -> list[float]:
        """Return the p-values of the residual and of its components in the order of values ``(N,)``."""
        by_plane = neighbour_p_value(z, neighbours_in_order(planes, values, least))
        return [by_plane, *neighbour_p_values(components, neighbours_in_order(one_group, values, least))]

    for name, values in in_time.items():
        add("in_time", (name,), in_order(values))
    for name, values in (angles | _places(state)).items():
        add("single", (name,), in_order(values))
    for component in _gravity(state):
        add("single", (GRAVITY,), in_order(component))
    for a, b in itertools.combinations(angles, 2):
        add("pair", (a, b), in_order(angles[a] + angles[b]))
        add("pair", (a, b), in_order(angles[a] - angles[b]))
        pairs = neighbours_in_two(np.column_stack([angles[a], angles[b]]), state.settings.autocorrelation)
        add("pair", (a, b), neighbour_p_values(components, pairs))
    for name, groups in columns_of_few_values(state.dataset, least).items():
        found.setdefault("few_values", [])
        add("few_values", (name,), differences_between_groups(components, groups, least))
    corrected: dict[tuple[str, ...], float] = {}
    for family in found.values():
        for names, chance in family:
            corrected[names] = min(corrected.get(names, np.inf), chance * len(family) * len(found))
    return corrected


def _moving_angles(state: FittedState) -> dict[str, Array]:
    """Return the angles ``(N,)`` [rad] of the joints that move, by name."""
    q, still = state.residuals.poses.q, state.settings.estimation.identifiability.still
    return {f"q{j + 1}": q[:, j] for j in range(q.shape[1]) if np.ptp(q[:, j]) > still}


def neighbour_p_value(z: Array, pairs: Array) -> float:
    """Return the p-value of the correlation of whitened residuals between neighbours.

    Args:
        z: ``(N, m)``, whitened residuals.
        pairs: ``(P, 2)``, indices of the poses of each pair of neighbours.
    """
    products = np.sum(z[pairs[:, 0]] * z[pairs[:, 1]], axis=1)
    return _p_values(products[:, None], pairs, len(z))[0]


def neighbour_p_values(components: Array, pairs: Array) -> list[float]:
    """Return the same p-value for each of the K columns of ``components`` ``(N, K)``."""
    return _p_values(components[pairs[:, 0]] * components[pairs[:, 1]], pairs, len(components))


def _p_values(products: Array, pairs: Array, n_poses: int) -> list[float]:
    """Return the p-value of each of K sums of products ``(P, K)`` over P pairs of neighbours ``(P, 2)``, if the sign of each pose is random.

    A p-value that is small by the normal distribution is computed again from the distribution of the sum itself (``sign_flips``), whose tail is
    heavier if a few poses have large residuals.
    """
    sums, lengths = products.sum(axis=0), np.sqrt(np.sum(products**2, axis=0))
    seen = lengths > 0
    found = np.where(seen, ndtr(-sums / np.where(seen, lengths, 1.0)), 1.0)
    for k in np.flatnonzero(found < _NORMAL_SUFFICES):
        found[k] = upper_tail(products[:, k], pairs, n_poses)
    return [float(chance) for chance in found]


def neighbours_in_order(
    groups: Array, order: Array, least_poses: int = DEFAULTS.autocorrelation.least_poses
) -> Array:
    """Return the pairs of neighbours ``(P, 2)`` in an order ``(N,)`` within each group ``(N,)``; groups of fewer than ``least_poses`` have none."""
    pairs = [np.zeros((0, 2), dtype=int)]
    for group in np.unique(groups):
        mine = np.flatnonzero(groups == group)
        if len(mine) >= least_poses:
            mine = mine[np.argsort(order[mine], kind="stable")]
            pairs += [np.column_stack([mine[lag:], mine[:-lag]]) for lag in LAGS]
    return np.concatenate(pairs)


def neighbours_in_two(values: Array, settings: AutocorrelationSettings = DEFAULTS.autocorrelation) -> Array:
    """Return the pairs of neighbours ``(P, 2)`` in two variables ``(N, 2)``: each pose with the nearest poses by rank, as many as there are lags.

    Every pair is listed once. There are none with fewer than ``settings.least_poses`` poses.
    """
    if len(values) < settings.least_poses:
        return np.zeros((0, 2), dtype=int)
    ranks = rankdata(values, axis=0)
    found = np.asarray(KDTree(ranks).query(ranks, k=len(LAGS) + 1)[1])[:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(len(values)), len(LAGS)), found.ravel()])
    # As one number each: whole rows take ten times as long to sort.
    found = np.unique(pairs.min(axis=1) * len(values) + pairs.max(axis=1))
    return np.column_stack(np.divmod(found, len(values)))


def components_along(state: FittedState, z: Array) -> Array:
    """Return the component of each pose's residual along its derivative by each of K quantities that might err ``(N, K)``, in standard errors.

    The quantities are the angle (or travel) of every joint, a growth of all lengths in proportion, and the components of the sensor's pose on the
    flange and of the base's pose. A quantity on which no row depends is left out.

    Args:
        state: The fitted state.
        z: ``(N, m)``, its whitened residuals.
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
    return components[:, sizes.max(axis=0) > NO_DERIVATIVE * sizes.max()]


def _recorded_in_time(state: FittedState) -> dict[str, Array]:
    """Return the order of acquisition, and every column recorded with the poses that has enough different values, ``(N,)`` each, by name."""
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
    """Return the position of the sensor along the two axes of its target plane [m], ``(N,)`` each, by name; nothing if targets are no planes."""
    target = state.model.target
    if not isinstance(target, Planes):
        return {}
    origins = state.residuals.kinematics(state.model).T_base_sensor[:, :3, 3]
    along = np.einsum("nkx,nx->kn", target.tangents[state.residuals.measurement.target_index], origins)
    return {"plane_u": along[0], "plane_v": along[1]}


def _gravity(state: FittedState) -> Array:
    """Return the three components of the direction of gravity in the sensor's frame ``(3, N)``; ``(0, N)`` if gravity is not stated."""
    down = state.model.robot.down
    if not down.any():
        return np.zeros((0, state.dataset.n_poses))
    rotations = state.residuals.kinematics(state.model).T_base_sensor[:, :3, :3]
    return np.einsum("nij,i->jn", rotations, down)
