"""Residual, Jacobian and fit of measurements of planes, in the compiled library; their rows are linear in the contact vector."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scalar.kernels import LIBRARY, Array, FreeStruct, ProblemStruct, checked, contiguous

ILL_CONDITIONED = -1


@dataclass(frozen=True, eq=False)
class FitEnd:
    """Where a fit ended.

    Attributes:
        info: MINPACK's number for the reason.
        vector: ``(P,)``, all coordinates.
        evaluations: How often the residual was computed.
    """

    info: int
    vector: Array
    evaluations: int


class PlaneProblem:
    """N poses that measure K planes with m rows each: ``factors @ c``, c the contact vector ``(n.o - d, n.X, n.Z)``.

    n and d are the plane's normal and distance, o, X and Z the sensor's origin and axes.

    The coordinates ``(P,)`` are the geometry ``(5, n)``, the sensor's translation and rotation vector, and (u, v, d) of every plane.
    """

    def __init__(
        self,
        q: Array,
        index: NDArray[np.int64],
        factors: Array,
        T_base_0: Array,
        T_n_flange: Array,
        R_sensor: Array,
        normals: Array,
        tangents: Array,
    ) -> None:
        """Keep what does not change with the coordinates.

        Args:
            q: ``(N, n)`` [rad].
            index: ``(N,)``, which plane each pose measures.
            factors: ``(N, m, 3)``.
            T_base_0: ``(4, 4)``, before the first joint.
            T_n_flange: ``(4, 4)``, after the last joint.
            R_sensor: ``(3, 3)``, reference rotation of the sensor on the flange.
            normals: ``(K, 3)``, reference normals.
            tangents: ``(K, 2, 3)``.
        """
        floats = [
            contiguous(each) for each in (q, factors, T_base_0, T_n_flange, R_sensor, normals, tangents)
        ]
        index = np.ascontiguousarray(index, dtype=np.int64)
        self._kept = (*floats, index)  # the structure holds their addresses
        self.shape = len(q), factors.shape[1], 5 * q.shape[1] + 6 + 3 * len(normals)
        at = [each.ctypes.data for each in floats]
        self._struct = ProblemStruct(
            len(q), q.shape[1], len(normals), factors.shape[1], at[0], index.ctypes.data, *at[1:]
        )

    def residual(self, vector: Array) -> Array:
        """Return the rows ``(N, m)`` at coordinates ``(P,)``."""
        assert LIBRARY is not None
        N, m, _ = self.shape
        vector, residual = contiguous(vector), np.empty((N, m))
        checked(LIBRARY.linearise(ctypes.byref(self._struct), vector.ctypes.data, residual.ctypes.data, None))
        return residual

    def linearise(self, vector: Array) -> tuple[Array, Array]:
        """Return the rows ``(N, m)`` at coordinates ``(P,)`` and their Jacobian ``(N, m, P)``."""
        assert LIBRARY is not None
        N, m, P = self.shape
        vector, residual, jacobian = contiguous(vector), np.empty((N, m)), np.empty((N, m, P))
        checked(
            LIBRARY.linearise(
                ctypes.byref(self._struct), vector.ctypes.data, residual.ctypes.data, jacobian.ctypes.data
            )
        )
        return residual, jacobian

    def fit(
        self,
        start: Array,
        free: NDArray[np.int64],
        mean: Array,
        weight: Array,
        *,
        tolerance: float,
        first_step: float,
        max_evaluations: int,
    ) -> FitEnd | None:
        """Return the least-squares optimum by the steps of MINPACK on the normal equations; None where these are too ill-conditioned.

        Args:
            start: ``(P,)``.
            free: ``(F,)``, indices of the free coordinates.
            mean: ``(F,)``, means of the priors on them.
            weight: ``(F,)``, one over the standard deviation of the prior; 0 where there is none.
            tolerance: Relative change of the cost, and of the coordinates, below which the fit has converged.
            first_step: Longest first step relative to the scaled norm of the coordinates: the ``factor`` of MINPACK.
            max_evaluations: The fit ends after so many evaluations of the residual.
        """
        assert LIBRARY is not None
        free = np.ascontiguousarray(free, dtype=np.int64)
        mean, weight, vector = contiguous(mean), contiguous(weight), np.array(start, dtype=np.float64)
        chosen = FreeStruct(len(free), free.ctypes.data, mean.ctypes.data, weight.ctypes.data)
        cost, evaluations = ctypes.c_double(), ctypes.c_int64()
        info = LIBRARY.fit(
            ctypes.byref(self._struct), ctypes.byref(chosen), tolerance, first_step, max_evaluations, vector.ctypes.data,
            ctypes.byref(cost), ctypes.byref(evaluations),
        )  # fmt: skip
        return None if info == ILL_CONDITIONED else FitEnd(info, vector, evaluations.value)
