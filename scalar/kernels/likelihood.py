"""Compute the restricted likelihood of correlated heights in the compiled library; None without it."""

from __future__ import annotations

import ctypes

import numpy as np

from scalar import kernels
from scalar.kernels import NOT_POSITIVE, Array, address, checked, contiguous


def restricted_likelihood(pairs: Array, bordering: Array, nugget: float) -> tuple[float, Array] | None:
    """Return half the sum of all log determinants, and ``y' P y`` of each of S scans ``(S,)``, as ``ScanSample.factored``.

    None is returned without the library, and if a correlation is not positive definite.

    Args:
        pairs: ``(S, m (m - 1) / 2)``, correlation of each pair of the m points of a scan, in the order of ``np.triu_indices``.
        bordering: ``(S, 3, m)``, the two columns of each scan's line, and its heights.
        nugget: Added to the diagonal, where the variance is 1.
    """
    if kernels.LIBRARY is None:
        return None
    pairs, bordering = contiguous(pairs), contiguous(bordering)
    S, _, m = bordering.shape
    determinants, squares = ctypes.c_double(), np.empty(S)
    status = kernels.LIBRARY.restricted_likelihood(
        S, m, address(pairs), address(bordering), nugget, ctypes.byref(determinants), address(squares)
    )
    if status == NOT_POSITIVE:
        return None
    checked(status)
    return determinants.value, squares
