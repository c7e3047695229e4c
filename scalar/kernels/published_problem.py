"""The original paper's model of scans on planes, in the compiled library: its rows, and how a step of each parameter changes them."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from scalar.kernels import LIBRARY, Array, PublishedStruct, address, checked, contiguous

READINGS = ("raise", "abs", "clip")
"""How the root of a negative number is read, in the order in which ``published_model.h`` counts the readings: as NaN (on which the caller ends
the fit, or does not), as the root of the absolute value, or as zero."""


class PublishedProblem:
    """N poses that measure K planes, with three rows for each pose: ``factors @ c`` with the contact vector c = ``(n.o - d, n.X, n.Z)``.

    n and d are the plane's normal and distance, o, X and Z the sensor's origin and axes in the base frame.
    The ``P = 4 n + 7 + 4 K`` parameters, in metres and radians, are a, alpha, d and theta, each ``(n,)``; the sensor's rotation axis ``(3,)``, angle
    and position ``(3,)`` on the flange; and the normal ``(3,)`` and distance of every plane.
    """

    def __init__(
        self,
        q: Array,
        index: NDArray[np.intp],
        factors: Array,
        beta: Array,
        T_base_0: Array,
        T_n_flange: Array,
        n_planes: int,
        reading: str,
    ) -> None:
        """Keep what does not change with the parameters.

        Args:
            q: ``(N, n)`` [rad].
            index: ``(N,)``, which plane each pose measures.
            factors: ``(N, 3, 3)``, the triangular factor of the points ``[1, x, z]`` of each scan, to which a scan is compressed.
            beta: ``(n,)`` [rad].
            T_base_0: ``(4, 4)``, before the first joint.
            T_n_flange: ``(4, 4)``, after the last joint.
            n_planes: K.
            reading: One of ``READINGS``.
        """
        floats = [contiguous(each) for each in (q, factors, beta, T_base_0, T_n_flange)]
        index = np.ascontiguousarray(index, dtype=np.int64)
        self._kept = (*floats, index)  # the structure holds their addresses
        N, n = q.shape
        self.shape = N, 4 * n + 7 + 4 * n_planes
        at = [address(each) for each in floats]
        self._struct = PublishedStruct(
            N, n, n_planes, READINGS.index(reading), at[0], address(index), *at[1:]
        )

    def rows(self, values: Array) -> Array:
        """Return the rows ``(3 N,)`` at parameters ``(P,)``."""
        return self._found(values, None)[0]

    def changes(self, values: Array, steps: Array) -> Array:
        """Return the change of the rows, ``(3 N, P)``, when one parameter at a time is stepped and the roots are recomputed.

        Args:
            values: ``(P,)``.
            steps: ``(P,)``.
        """
        return self._found(values, contiguous(steps))[1]

    def _found(self, values: Array, steps: Array | None) -> tuple[Array, Array]:
        assert LIBRARY is not None
        N, P = self.shape
        values, rows = contiguous(values), np.empty(3 * N)
        changes = np.empty((0 if steps is None else 3 * N, P))
        stepped, out = (None, None) if steps is None else (address(steps), address(changes))
        checked(LIBRARY.published(ctypes.byref(self._struct), address(values), stepped, address(rows), out))
        return rows, changes
