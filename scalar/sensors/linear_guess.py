"""The linear first guess of a scanner's pose (Section III-A of the paper), and the planes that go with it.

For a known plane (n, d), the residual is linear in the scanner's origin p and its axes X and Z on the flange: the contact vector is
``c = (n'.p + n'_4 - d, n'.X, n'.Z)`` with ``(n', n'_4) = (n, 0)^T T_base_flange``. These nine numbers follow from one linear least-squares problem,
and the rotation is the one nearest to the axes found. Since planes are known only roughly, planes and scanner are then refined in turn, with the
nominal arm. The result is usable even if the initial guess of the floor is 30 degrees off.
"""

from __future__ import annotations

import numpy as np

from scalar.errors import Undetermined
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array, nearest_rotation, transform
from scalar.kernels.linear_start import linear_start
from scalar.sensors.scans import Scans
from scalar.sensors.target import Guess

_ALTERNATIONS = 8
_UNKNOWNS = 9


def guesses(
    scans: Scans, T_base_flange: Array, planes: Planes, gravity: Array, thorough: bool
) -> list[Guess]:
    """Return guesses of the scanner's pose from the most level plane, as in the paper, and then from all planes together.

    Args:
        scans: What was measured.
        T_base_flange: ``(N, 4, 4)``, of the nominal arm.
        planes: The planes at their initial guesses.
        gravity: ``(3,)`` [m/s^2], base frame.
        thorough: Whether to guess from all planes together as well.

    Raises:
        Undetermined: Neither set of poses determines a guess.
    """
    found: list[Guess] = []
    failure: Undetermined | None = None
    for use in _plane_choices(scans, planes, gravity)[: None if thorough else 1]:
        try:
            first, last = _alternate(scans, T_base_flange, planes, use)
            found += [Guess(last, True), Guess(first, False)]
        except Undetermined as error:
            failure = error
    if not found and failure is not None:
        raise failure
    return found


def linear_guess(scans: Scans, T_base_flange: Array, planes: Planes, use: Array) -> Array:
    """Return the scanner's pose on the flange ``(4, 4)`` from scans of planes taken as known.

    Args:
        scans: What was measured.
        T_base_flange: ``(N, 4, 4)``, of the nominal arm.
        planes: The planes, taken as known.
        use: ``(N,)`` bool, the poses to use; the paper takes those on the bottom plane.

    Raises:
        Undetermined: The poses do not determine the nine numbers.
    """
    index = scans.target_index[use]
    n = planes.normals[index]
    T = T_base_flange[use]
    n_flange = np.einsum("nx,nxy->ny", n, T[:, :3, :3])
    offset = np.einsum("nx,nx->n", n, T[:, :3, 3]) - planes.distances[index]
    R = scans.R[use][:, :, :3]
    A = (R[:, :, :, None] * n_flange[:, None, None, :]).reshape(-1, _UNKNOWNS)
    b = -(R[:, :, 0] * offset[:, None]).ravel()
    # The triangular factor has the same solution and the same singular values as all rows, at a fraction of the cost.
    factor = np.asarray(np.linalg.qr(np.column_stack([A, b]), mode="r"))[: _UNKNOWNS + 1]
    solution, _, rank, _ = np.linalg.lstsq(factor[:, :_UNKNOWNS], factor[:, _UNKNOWNS], rcond=1e-10)
    if rank < _UNKNOWNS:
        raise Undetermined(
            [f"the scans determine only {rank} of the {_UNKNOWNS} numbers of a first guess of the scanner's pose; "
             "add poses that turn the scanner about all three axes, or state sensor.nominal_pose"]
        )  # fmt: skip
    p, x, z = solution[:3], solution[3:6], solution[6:]
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return transform(nearest_rotation(np.column_stack([x, np.cross(z, x), z])), p)


def _plane_choices(scans: Scans, target: Planes, gravity: Array) -> list[Array]:
    """Return sets of poses to guess from: those on the most level plane first, as in the paper, then all."""
    up = -gravity / max(float(np.linalg.norm(gravity)), 1e-12)
    level = int(np.argmax(np.abs(target.normals @ up)))
    return [scans.target_index == level, np.ones(len(scans.target_index), dtype=bool)]


def _alternate(scans: Scans, T_base_flange: Array, target: Planes, use: Array) -> tuple[Array, Array]:
    """Return the first linear guess of the scanner's pose on the flange ``(4, 4)``, and the last, after fitting planes and guessing in turn.

    Args:
        scans: What was measured.
        T_base_flange: ``(N, 4, 4)``, of the nominal arm.
        target: The planes at their initial guesses.
        use: ``(N,)`` bool, the poses for the first guess; later ones use all.
    """
    compiled = linear_start(
        scans.R[:, :, :3],
        scans.R_metric[:, :3, :3],
        T_base_flange,
        scans.target_index,
        use,
        target.normals,
        target.distances,
        _ALTERNATIONS,
    )
    if compiled is not None:
        return compiled
    T = first = linear_guess(scans, T_base_flange, target, use)
    everywhere = np.ones(len(scans.target_index), dtype=bool)
    for _ in range(_ALTERNATIONS):
        planes = scans.fitted_target(T_base_flange @ T, target)
        T = linear_guess(scans, T_base_flange, planes, everywhere)
    return first, T
