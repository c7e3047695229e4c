"""The covariance of predicted poses, from that of the parameters: ``C_pose = M C M'``, with M the derivatives by the free parameters.

Parameters that are fixed because no measurement determines them (the place of the base, say) are taken as exact: they define the frame in which
poses are predicted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.targets_on_flange import own_screws, sensor_to_target
from scalar.geometry.se3 import Array


def pose_deviations(
    model: Model,
    kinematics: Kinematics,
    free: Sequence[str],
    covariance: Array,
    on_flange: str | None = None,
) -> Array | None:
    """Return a root D of the covariances of the predicted poses, ``(N, 6, K)`` [m, rad]: ``D D'`` are the covariances ``(N, 6, 6)``.

    Each column of D is the deviation of a pose by one standard deviation of one of K independent causes. The first three rows are the shift of the
    origin of the sensor, or of one of several targets on the flange, the others a small rotation about this origin, both in the base frame. The
    result is None if the calibration has no covariance.

    Args:
        model: The calibrated one.
        kinematics: Of the predicted poses.
        free: Names of the F parameters that were estimated.
        covariance: ``(F, F)``.
        on_flange: Name of a further target on the flange; None for the sensor.
    """
    index = np.array([model.names.index(name) for name in free], dtype=int)
    # Predictions do not depend on the target's coordinates, so only the marginal covariance of the others counts.
    target = model.blocks["target"]
    place = sensor_to_target(model, on_flange)
    own = own_screws(model, on_flange)
    moves = (index < target.start) | (index >= target.stop - own.shape[1])
    moves |= index >= target.stop
    marginal = covariance[np.ix_(moves, moves)]
    if not np.all(np.isfinite(marginal)):
        return None
    values, vectors = np.linalg.eigh(marginal)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    T = kinematics.T_base_sensor @ place
    screws = kinematics.screws()
    moved = np.concatenate(
        [screws[:, 3:] + np.cross(screws[:, :3], T[:, :3, 3, None], axis=1), screws[:, :3]], axis=1
    )
    R = kinematics.T_base_sensor[:, :3, :3]
    shared = slice(target.stop - own.shape[1], target.stop)
    moved[:, :, shared] = np.concatenate([R @ own[:3], R @ own[3:]], axis=1)
    return moved[:, :, index[moves]] @ root
