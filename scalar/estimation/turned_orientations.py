"""Single poses whose measured orientation is far from the arm's, as where a board that looks alike from both ends was recognised the wrong way round.

Three poses determine both constant rotations (``scalar.estimation.orientation_frames``). They are taken from the three, of many random ones, under
which most poses agree (least trimmed squares from random sets, as in RANSAC: Fischler and Bolles, 1981).
"""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.formats import ORIENTATION
from scalar.errors import Fault, InvalidInput
from scalar.estimation.orientation_frames import Orientations, angles_left, constants, were_measured
from scalar.estimation.pose_consistency import in_runs
from scalar.estimation.settings import GrossErrorSettings
from scalar.geometry.se3 import Array, exp_so3
from scalar.sensors import kind_of
from scalar.units import DEG

_DRAWS = 200  # with a fifth of wrong poses half of them are free of these
_SEED = 0
_LEAST_POSES = 6  # of a target in a session: three of them have to agree with those that were drawn
_FAR = 15 * DEG  # no effect of an arm, and no instrument, turns an orientation by as much
_AGREE = 5 * DEG  # the orientations of an arm differ from those of its data sheet by a degree or two
_MOST_TURNED = 0.35  # of the poses, chosen: of two hundred random draws of three, fifty are then free of them
_ROUNDS = 3  # fits to the poses that agree; later ones change nothing


def not_turned(dataset: Dataset, usable: Array, settings: GrossErrorSettings) -> Array:
    """Return which of the usable poses ``(N,)`` bool have orientations as the nominal arm has them; arguments as in ``turned_by``."""
    return usable & (turned_by(dataset, usable, settings) == 0.0)


def refuse_turned(dataset: Dataset, settings: GrossErrorSettings) -> None:
    """Refuse a dataset in which the measured orientations of single poses are half a turn from the arm's, and those of all others are not far.

    Raises:
        InvalidInput: There are such poses.
    """
    angles = turned_by(dataset, np.ones(dataset.n_poses, dtype=bool), settings)
    far = np.flatnonzero(angles)
    if not len(far) or np.any(angles[far] < np.pi - _FAR):
        return
    message = (
        "the measured orientation is half a turn from the arm's, and most others agree with the arm to a few degrees: a board that looks alike from "
        "both ends was probably recognised the wrong way round; remove the pose, or let 'scalar diagnose' set it aside"
    )
    measured_in, columns = kind_of(dataset).format.measured_in, ",".join(ORIENTATION)
    raise InvalidInput(
        [Fault(measured_in, f"pose {dataset.pose_ids[row]}: {message}", None, columns) for row in far]
    )


def turned_by(dataset: Dataset, usable: Array, settings: GrossErrorSettings) -> Array:
    """Return by which angle the orientation of each pose is far from the nominal arm's, ``(N,)`` [rad]; 0 where it is not far.

    Args:
        dataset: What was measured. Each target and each session has constant rotations of its own.
        usable: ``(N,)`` bool, the poses to judge. None is far if no orientations were measured, or if so many are, or so many in a row, that
            something else may be wrong: the description of the arm, the way in which orientations are read, the order of the rows.
        settings: Thresholds.
    """
    angles = np.zeros(dataset.n_poses)
    if not were_measured(dataset):
        return angles
    pose, given = dataset.pose_of_point, Orientations.of(dataset)
    measured = exp_so3(given.vectors)
    for mine in given.groups():
        rows = np.flatnonzero(mine & usable[pose])
        if len(rows) < _LEAST_POSES:
            continue
        left = _angles_left(given.arm[rows], measured[rows], settings.core_share)
        far = left > _FAR
        agree = np.quantile(left, settings.core_share) < _AGREE
        if agree and far.mean() <= _MOST_TURNED:
            np.maximum.at(angles, pose[rows[far]], left[far])
    return np.zeros_like(angles) if in_runs(dataset, angles > 0, settings).any() else angles


def _angles_left(arm: Array, measured: Array, core_share: float) -> Array:
    """Return the angle ``(N,)`` [rad] of each measured rotation from ``Y arm X``, for the X and Y with which the trusted share agrees best.

    Args:
        arm: ``(N, 3, 3)``.
        measured: ``(N, 3, 3)``.
        core_share: The share of the poses that is trusted.
    """
    best = _angles_from(arm, measured, np.arange(len(arm)))
    if best.max() <= _FAR:
        return best
    rng = np.random.default_rng(_SEED)
    trusted = max(int(np.ceil(core_share * len(arm))), 3)
    for _ in range(_DRAWS):
        drawn = rng.choice(len(arm), 3, replace=False)
        left = _angles_from(arm, measured, drawn)
        if np.sort(left)[:trusted].sum() < np.sort(best)[:trusted].sum():
            best = left
    for _ in range(_ROUNDS):
        best = _angles_from(arm, measured, np.flatnonzero(best <= max(_FAR, np.sort(best)[trusted - 1])))
    return best


def _angles_from(arm: Array, measured: Array, rows: Array) -> Array:
    """Return the angle ``(N,)`` [rad] of each measured rotation from ``Y arm X`` with the X and Y of some rows ``(k,)``."""
    k = np.arange(len(rows))
    return angles_left(arm, measured, *constants(arm[rows], measured[rows], k, np.roll(k, 1)))
