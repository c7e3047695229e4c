"""At which held-out poses the others show where the target stands: an error elsewhere says nothing of the arm.

A target in two sockets shows how the tracker is turned; without the few poses at one of them, the poses there would err by centimetres. So would
those of a session of which hardly any pose is left, and those of a plane of which hardly any is.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

# Times the variance of a measurement: if the place of the target alone is less certain at a pose, an error there shows that place and not the arm.
_MOST_LEVERAGE = 4.0
_NO_INFORMATION = 1e-9  # of a coordinate whose derivatives have unit length: it makes directions without information uncertain, and changes no others


def places_shown(J: Array, trained: Array) -> Array:
    """Return at which poses ``(N,)`` bool the place of the target is known from the trained poses, given the arm.

    Args:
        J: ``(N, m, k)``, derivatives of the whitened residuals by the k coordinates of the target.
        trained: ``(N,)`` bool.
    """
    J = J / np.maximum(np.linalg.norm(J, axis=(0, 1)), 1e-300)
    information = np.einsum("nmf,nmg->fg", J[trained], J[trained])
    response = np.linalg.solve(information + _NO_INFORMATION * np.eye(J.shape[2]), np.swapaxes(J, 1, 2))
    return np.linalg.norm(J @ response, 2, axis=(1, 2)) < _MOST_LEVERAGE
