"""The covariance of predicted poses, from that of the parameters: ``C_pose = M C M'``, with M the screws of what is free.

What is fixed because no measurement shows it (the base's place, say) is taken as exact: the poses are those of the frame that it defines.
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
    """Return independent deviations of the predicted poses, of one standard deviation each, ``(N, 6, K)`` [m, rad]; None without covariance.

    The first three rows are the shift of the origin of the sensor, or of one of several targets on the flange, the others a small turn about
    its origin, both in the base frame.
    Their products ``D D'`` are the covariances ``(N, 6, 6)``.

    Args:
        model: The calibrated one.
        kinematics: Of the predicted poses.
        free: F names of what was estimated.
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
