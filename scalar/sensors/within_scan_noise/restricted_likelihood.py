"""The restricted likelihood of a correlation within scans.

For heights y of a scan with correlation C, and the columns X of its own line (whose height and slope carry no information on the noise):

    -2 log L = log |C| + log |X' C^-1 X| + y' P y,    P = C^-1 - C^-1 X (X' C^-1 X)^-1 X' C^-1

(Patterson and Thompson, Biometrika 58, 1971), summed over the scans, with their common variance profiled out. All terms follow from one
Cholesky factor L of C bordered by X and y, whose last rows are ``(L^-1 [X y])^T``. C has a diagonal of 1; it is kept as the correlations of all pairs
of points i < j, in the order of ``np.triu_indices``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.geometry.se3 import Array
from scalar.kernels.likelihood import restricted_likelihood
from scalar.sensors.within_scan_noise.correlation_shapes import Kernel, Part

_NUGGET = 1e-6  # added to the diagonal, where the variance is 1: keeps a smooth kernel's matrix invertible
_BORDER = 1e9  # keeps the bordered matrix positive definite: larger than y' C^-1 y of any standardised scan


@dataclass(frozen=True, eq=False)
class ScanSample:
    """S scans of m points each, with heights in units of the scan's noise level.

    Attributes:
        bordering: ``(S, 3, m)``, the two columns of each scan's line, and its heights.
        pixel: ``(S, m)`` [points], position of each point along the rays.
        surface: ``(S, m)`` [m], position along the surface.
    """

    bordering: Array
    pixel: Array
    surface: Array

    def some(self, every: int) -> ScanSample:
        """Return a sample of every ``every``-th scan."""
        return ScanSample(self.bordering[::every], self.pixel[::every], self.surface[::every])

    @property
    def degrees_of_freedom(self) -> int:
        """Return the degrees of freedom of each scan about its line."""
        return self.bordering.shape[2] - 2

    @cached_property
    def _distances(self) -> tuple[Array, Array]:
        """Return the distance of each pair of points of a scan along the rays [points], and along the surface [m], ``(S, m (m - 1) / 2)`` each."""
        i, j = np.triu_indices(self.bordering.shape[2], 1)
        return np.abs(self.pixel[:, i] - self.pixel[:, j]), np.abs(self.surface[:, i] - self.surface[:, j])

    def kernel(self, kernel: Kernel, length: float) -> Array:
        """Return the correlation ``(S, m (m - 1) / 2)`` of pairs of points by a kernel with a length [points or m]."""
        return kernel(self._distances[kernel.of_surface] / length)

    def correlation(self, parts: Sequence[Part]) -> Array:
        """Return the correlation ``(S, m (m - 1) / 2)`` of pairs of points by several components; the rest of the variance is white."""
        found = np.zeros_like(self._distances[0])
        for p in parts:
            found += p.share * self.kernel(p.kernel, p.length)
        return found

    def factored(self, correlation: Array) -> tuple[float, Array]:
        """Return half the sum of all log determinants, and ``y' P y`` of each scan ``(S,)``, for correlations as ``correlation`` returns them."""
        compiled = restricted_likelihood(correlation, self.bordering, _NUGGET)
        if compiled is not None:
            return compiled
        S, k, m = self.bordering.shape
        i, j = np.triu_indices(m, 1)
        bordered = np.zeros((S, m + k, m + k))
        bordered[:, i, j] = bordered[:, j, i] = correlation
        bordered[:, m:, :m] = self.bordering
        bordered[:, :m, m:] = np.swapaxes(self.bordering, 1, 2)
        bordered[:, m:, m:] = _BORDER * np.eye(k)
        bordered[:, np.arange(m), np.arange(m)] = 1.0 + _NUGGET
        L = np.linalg.cholesky(bordered)
        solved = L[:, m:, :m]
        G = solved @ np.swapaxes(solved, 1, 2)
        lines = np.linalg.cholesky(G[:, :-1, :-1])
        projected = np.linalg.solve(lines, G[:, :-1, -1:])[:, :, 0]
        determinants = np.sum(np.log(np.diagonal(L, axis1=1, axis2=2)[:, :m]))
        determinants += np.sum(np.log(np.diagonal(lines, axis1=1, axis2=2)))
        return float(determinants), G[:, -1, -1] - np.sum(projected**2, axis=1)

    def log_likelihood(self, correlation: Array) -> float:
        """Return the restricted log likelihood, up to a constant [nats]."""
        determinants, squares = self.factored(correlation)
        n = len(squares) * self.degrees_of_freedom
        return -determinants - 0.5 * n * float(np.log(np.sum(squares) / n))
