"""Is what is left noise? Poses that are neighbours in time, or in a joint's angle, have residuals that are alike where something acts on them.

A noise of whole poses is drawn anew at every pose. Before it is given a name its draws are put in the order of everything that is
recorded, plate by plate, and each is multiplied by those that follow: ``t = sum z_i . z_(i+l) / sqrt(sum (z_i . z_(i+l))^2)``, about
normal where the order means nothing (von Neumann's ratio, with the spread of the products taken from the products themselves).
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from scalar.diagnosis.state import State
from scalar.identifiability import STILL
from scalar.planes import Planes
from scalar.se3 import Array

LAGS = (1, 2, 3)
P_VALUE = 1e-4  # corrected for all orders that were tried
LEAST_POSES = 12  # of a plate, for its neighbours to be near one another


def alike(z: Array, groups: Array, order: Array) -> float:
    """Return the chance that neighbours in an order are as much alike as these where the order means nothing.

    Args:
        z: ``(N, m)``, residuals of equal spread.
        groups: ``(N,)``, only poses of the same group are neighbours.
        order: ``(N,)``, anything that can be sorted.
    """
    products = []
    for group in np.unique(groups):
        mine = np.flatnonzero(groups == group)
        if len(mine) < LEAST_POSES:
            continue
        sorted_z = z[mine[np.argsort(order[mine], kind="stable")]]
        products += [np.sum(sorted_z[lag:] * sorted_z[:-lag], axis=1) for lag in LAGS]
    if not products:
        return 1.0
    p = np.concatenate(products)
    length = float(np.sqrt(np.sum(p**2)))
    return float(norm.sf(p.sum() / length)) if length > 0 else 1.0


def depends_on(state: State) -> list[str]:
    """Return in which columns neighbouring poses have residuals that are alike beyond chance, the surest first: none where what is left is noise."""
    z = state.background().residual
    poses, dataset = state.residuals.poses, state.dataset
    groups = state.residuals.measurement.target_index
    orders = {f"q{j + 1}": poses.q[:, j] for j in range(poses.q.shape[1]) if np.ptp(poses.q[:, j]) > STILL}
    orders["time" if "time" in dataset.poses else "order"] = poses.order
    for name in ("temperature", *dataset.covariates):
        if name in dataset.poses and len(np.unique(dataset.poses[name].to_numpy())) > LEAST_POSES:
            orders[name] = dataset.poses[name].to_numpy(dtype=float)
    orders |= _places(state)
    chances = {name: alike(z, groups, order) * len(orders) for name, order in orders.items()}
    return sorted((name for name, p in chances.items() if p < P_VALUE), key=lambda name: chances[name])


def _places(state: State) -> dict[str, Array]:
    """Return where on its plate the sensor looked, along the plate's own two axes [m], ``(N,)`` each; nothing for a tracker, which has no plates."""
    target = state.model.target
    if not isinstance(target, Planes):
        return {}
    origins = state.residuals.kinematics(state.model).T_base_sensor[:, :3, 3]
    along = np.einsum("nkx,nx->kn", target.tangents[state.residuals.measurement.target_index], origins)
    return {"plate_u": along[0], "plate_v": along[1]}
