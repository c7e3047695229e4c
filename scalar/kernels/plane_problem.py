"""Compute residual, Jacobian and fit of measurements of planes by the compiled library; their rows are linear in the contact vector."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scalar.kernels import LIBRARY, Array, FreeStruct, ProblemStruct, address, checked, contiguous

ILL_CONDITIONED = -1
"""What the library returns instead of MINPACK's number if the normal equations are too ill-conditioned."""


@dataclass(frozen=True, eq=False)
class FitEnd:
    """The end of a fit.

    Attributes:
        info: Reason for which the fit ended, as MINPACK numbers the reasons.
        vector: ``(P,)``, all coordinates at the end.
        evaluations: Number of evaluations of the residual.
    """

    info: int
    vector: Array
    evaluations: int


class PlaneProblem:
    """The residual of N poses that each measure one of K planes, with m rows for each pose.

    The rows of a pose are ``factors @ c`` with the contact vector ``c = (n.o - d, n.X, n.Z)``, where n and d are the normal and the distance of the
    plane, and o, X and Z the origin and the axes of the sensor, in the base frame.

    The P coordinates are the geometry ``(5, n)`` [m, rad], the translation [m] and the rotation vector [rad] of the sensor on the flange, and for
    every plane (u, v) of its normal and its distance d [m].
    """

    def __init__(
        self,
        turned: Array,
        index: NDArray[np.int64],
        factors: Array,
        T_base_0: Array,
        T_n_flange: Array,
        R_sensor: Array,
        normals: Array,
        tangents: Array,
    ) -> None:
        """Store what does not change with the coordinates.

        Args:
            turned: ``(N, n, 2)``, cosine and sine of the joint angles, as ``scalar.kernels.chain.turned`` returns them.
            index: ``(N,)``, index of the plane that each pose measures.
            factors: ``(N, m, 3)``, the factors of the contact vector in each row.
            T_base_0: ``(4, 4)``, transform before the first joint.
            T_n_flange: ``(4, 4)``, transform after the last joint.
            R_sensor: ``(3, 3)``, reference rotation of the sensor on the flange; the rotation vector turns the sensor from it.
            normals: ``(K, 3)``, reference normals of the planes.
            tangents: ``(K, 2, 3)``, the directions in which u and v move each normal.
        """
        floats = [
            contiguous(each) for each in (turned, factors, T_base_0, T_n_flange, R_sensor, normals, tangents)
        ]
        index = np.ascontiguousarray(index, dtype=np.int64)
        self._kept = (*floats, index)  # the structure holds their addresses
        N, n = turned.shape[:2]
        self.shape = N, factors.shape[1], 5 * n + 6 + 3 * len(normals)
        at = [address(each) for each in floats]
        self._struct = ProblemStruct(N, n, len(normals), factors.shape[1], at[0], address(index), *at[1:])

    def residual(self, vector: Array) -> Array:
        """Return the rows ``(N, m)`` at coordinates ``(P,)``."""
        assert LIBRARY is not None
        N, m, _ = self.shape
        vector, residual = contiguous(vector), np.empty((N, m))
        checked(LIBRARY.linearise(ctypes.byref(self._struct), address(vector), address(residual), None))
        return residual

    def linearise(self, vector: Array) -> tuple[Array, Array]:
        """Return the rows ``(N, m)`` at coordinates ``(P,)`` and their Jacobian ``(N, m, P)``."""
        assert LIBRARY is not None
        N, m, P = self.shape
        vector, residual, jacobian = contiguous(vector), np.empty((N, m)), np.empty((N, m, P))
        checked(
            LIBRARY.linearise(
                ctypes.byref(self._struct), address(vector), address(residual), address(jacobian)
            )
        )
        return residual, jacobian

    def normal_equations(self, vector: Array, free: NDArray[np.int64]) -> tuple[Array, Array, float]:
        """Return ``J'J`` ``(F, F)`` and ``J'r`` ``(F,)`` by the free coordinates at coordinates ``(P,)``, and the sum of squares ``r'r``.

        Args:
            vector: ``(P,)``.
            free: ``(F,)``, indices of the free coordinates.
        """
        assert LIBRARY is not None
        vector, free = contiguous(vector), np.ascontiguousarray(free, dtype=np.int64)
        F, none, squares = len(free), np.zeros(len(free)), ctypes.c_double()
        gram, gradient = np.empty((F, F)), np.empty(F)
        chosen = FreeStruct(F, address(free), address(none), address(none))
        at = (address(each) for each in (vector, gram, gradient))
        checked(LIBRARY.normals(ctypes.byref(self._struct), ctypes.byref(chosen), *at, ctypes.byref(squares)))
        return gram, gradient, squares.value

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
        """Return the least-squares optimum by the steps of MINPACK on the normal equations; None if these are too ill-conditioned.

        Args:
            start: ``(P,)``, coordinates from which the fit starts; those that are not free keep these values.
            free: ``(F,)``, indices of the free coordinates.
            mean: ``(F,)``, means of the priors of the free coordinates.
            weight: ``(F,)``, one over the standard deviation of each prior; 0 for a coordinate without a prior.
            tolerance: Relative change of the cost, and of the coordinates, below which the fit has converged.
            first_step: Longest first step relative to the scaled norm of the coordinates: the ``factor`` of MINPACK.
            max_evaluations: Number of evaluations of the residual after which the fit ends in any case.
        """
        assert LIBRARY is not None
        free = np.ascontiguousarray(free, dtype=np.int64)
        mean, weight, vector = contiguous(mean), contiguous(weight), np.array(start, dtype=np.float64)
        chosen = FreeStruct(len(free), address(free), address(mean), address(weight))
        cost, evaluations = ctypes.c_double(), ctypes.c_int64()
        info = LIBRARY.fit(
            ctypes.byref(self._struct), ctypes.byref(chosen), tolerance, first_step, max_evaluations, address(vector),
            ctypes.byref(cost), ctypes.byref(evaluations),
        )  # fmt: skip
        return None if info == ILL_CONDITIONED else FitEnd(info, vector, evaluations.value)
