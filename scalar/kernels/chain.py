"""Compute the end of a chain of revolute joints in many poses by the compiled library."""

from __future__ import annotations

import numpy as np

from scalar import kernels
from scalar.kernels import Array, address, checked, contiguous


def turned(q: Array) -> Array:
    """Return the cosine and the sine of joint angles ``(N, n)`` [rad], ``(N, n, 2)``; the library is needed."""
    assert kernels.LIBRARY is not None
    q = contiguous(q)
    found = np.empty((*q.shape, 2))
    kernels.LIBRARY.turned(q.size, address(q), address(found))
    return found


def ends(turned: Array, geometry: Array, T_base_0: Array, T_n_end: Array) -> Array:
    """Return where the end of a chain is in the base frame, ``(N, 4, 4)``; the library is needed.

    Args:
        turned: ``(N, n, 2)``, cosine and sine of the joint angles.
        geometry: ``(5, n)``, as for ``scalar.kernels.frames``.
        T_base_0: ``(4, 4)``, transform before the first joint.
        T_n_end: ``(4, 4)``, pose of the end in the frame of the last joint.
    """
    assert kernels.LIBRARY is not None
    N, n, _ = turned.shape
    found = np.empty((N, 4, 4))
    arrays = [contiguous(each) for each in (turned, geometry, T_base_0, T_n_end)]
    at = (address(each) for each in (*arrays, found))
    checked(kernels.LIBRARY.ends(N, n, *at))
    return found
