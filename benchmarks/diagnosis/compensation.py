"""Compensation by a Gaussian process: the residual error of the geometry is predicted from the joint angles, without naming a cause.

The error of the position of the scanner is a vector ``e(q)`` of three independent Gaussian processes with one kernel,
``a^2 exp(-sum_i (2 sin((q_i - q'_i) / 2))^2 / (2 l^2))``: angles a turn apart are the same. A scan shows of it the component along the normal
of its target plane: ``n . e(q) = -(mean distance of its points)``, with noise. Size a, length l and noise are those of greatest evidence on
a grid; where no process at all has more evidence, nothing is compensated.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from scalar.geometry.se3 import Array

LENGTHS = (0.3, 0.6, 1.2, 2.4, 4.8)
"""Lengths of the kernel that are tried, as chords [rad]."""
SHARES = (0.03, 0.1, 0.3, 0.6, 0.9, 0.97)
"""Shares of the residual's variance that are tried for the process; the rest is noise."""


class Compensation:
    """Gaussian process of the position's error over the joint angles."""

    def __init__(self, q: Array, normals: Array, distances: Array) -> None:
        """Fit size, length and noise of the process.

        Args:
            q: ``(N, n)`` [rad], of the measured poses. normals: ``(N, 3)``, of their target planes.
            distances: ``(N,)``, mean signed distances of their points from them [m].
        """
        self.q, self.normals = q, normals
        target = -distances
        scale = float(np.mean(target**2))
        along = normals @ normals.T
        chords = squared_chords(q, q)
        self.length, self.size, self.weights = 1.0, 0.0, np.zeros(len(q))
        best = -0.5 * len(q) * (1.0 + np.log(2 * np.pi * max(scale, 1e-300)))
        for length in LENGTHS:
            kernel = along * np.exp(-0.5 * chords / length**2)
            for share in SHARES:
                covariance = share * scale * kernel + (1 - share) * scale * np.eye(len(q))
                factor = cho_factor(covariance, lower=True)
                weights = cho_solve(factor, target)
                log_det = 2.0 * float(np.log(np.diag(factor[0])).sum())
                evidence = -0.5 * (float(target @ weights) + log_det + len(q) * np.log(2 * np.pi))
                if evidence > best:
                    best, self.length, self.size, self.weights = evidence, length, share * scale, weights

    def error_at(self, q: Array) -> Array:
        """Return the expected error ``(P, 3)`` [m] of the position at joint angles ``(P, n)``."""
        kernel = self.size * np.exp(-0.5 * squared_chords(q, self.q) / self.length**2)
        return kernel @ (self.weights[:, None] * self.normals)


def squared_chords(a: Array, b: Array) -> Array:
    """Return ``sum_i (2 sin((a_i - b_i) / 2))^2`` ``(A, B)`` of joint angles ``(A, n)`` and ``(B, n)`` [rad]."""
    total = np.zeros((len(a), len(b)))
    for i in range(a.shape[1]):
        total += (2.0 * np.sin(0.5 * (a[:, i, None] - b[None, :, i]))) ** 2
    return total
