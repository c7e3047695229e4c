"""Variances of random errors of whole poses, by maximum likelihood.

The rows of each pose, whitened for the noise within scans, have the covariance ``I + v K``, or ``I + v K + w u u'``: K and u say what an error of
unit variance does to the rows of that pose, and v and w are the same for all poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.special import chdtrc  # what scipy.stats.chi2.sf calls, without its checks of arrays

from scalar.geometry.se3 import Array

# A variance is sought within these powers of e of the one at which the error is as large as the noise.
_POWERS = -16.0, 24.0


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The eigenvalues ``(N, m)``, none negative, and the eigenvectors ``(N, m, m)`` of what an error adds to the covariance at unit variance."""

    values: Array
    vectors: Array

    @classmethod
    def of(cls, K: Array) -> Spectrum:
        """Return the spectrum of covariances ``(N, m, m)``."""
        values, vectors = np.linalg.eigh(K)
        return cls(np.maximum(values, 0.0), vectors)

    @property
    def typical(self) -> float:
        """Return the variance at which the error is as large as the noise."""
        return 1.0 / max(float(np.median(self.values[:, -1])), 1e-300)

    def along(self, rows: Array) -> Array:
        """Return the components ``(N, m)`` of rows ``(N, m)`` along the eigenvectors."""
        return np.einsum("nij,ni->nj", self.vectors, rows)


def chance_of(gain: float) -> float:
    """Return the probability of at least such a gain of log likelihood [nats] by one more variance if it is zero."""
    # Half of a chi-squared distribution, because a variance cannot be negative (Self and Liang, JASA 82, 1987).
    return float(0.5 * chdtrc(1, 2 * gain)) if gain > 0 else 1.0


def of_one(rows: Array, spectrum: Spectrum) -> tuple[float, float, float]:
    """Return the gain of log likelihood over v = 0 [nats], the variance v of greatest likelihood, and the standard error of v.

    Args:
        rows: ``(N, m)``, residual, whitened for the noise within scans.
        spectrum: Of K.
    """
    values, squares = spectrum.values, spectrum.along(rows) ** 2

    def cost(log_v: float) -> float:
        """Return minus the log likelihood, less a constant."""
        variance = 1.0 + np.exp(log_v) * values
        return 0.5 * float(np.sum(np.log(variance) + squares / variance))

    start = np.log(spectrum.typical)
    bounds = (start + _POWERS[0], start + _POWERS[1])
    result: Any = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-4})
    v = float(np.exp(result.x))
    variance = 1.0 + v * values
    information = 0.5 * float(np.sum((values / variance) ** 2))
    return 0.5 * float(np.sum(squares)) - float(result.fun), v, 1.0 / np.sqrt(max(information, 1e-300))


@dataclass(frozen=True, eq=False)
class TwoVariances:
    """The variances v and w of greatest likelihood of ``I + v K + w u u'``.

    Attributes:
        gain: Log likelihood, less that of v = w = 0 [nats].
        variances: ``(2,)``, v and w.
        covariance: ``(2, 2)``, of their estimates, by the expected information.
    """

    gain: float
    variances: Array
    covariance: Array


def of_two(rows: Array, spectrum: Spectrum, u: Array) -> TwoVariances:
    """Return the variances of greatest likelihood of a covariance with a second term of rank one.

    Args:
        rows: ``(N, m)``, residual, whitened for the noise within scans.
        spectrum: Of K.
        u: ``(N, m)``, by which the second changes the rows at unit size.
    """
    values, z, y = (x.T.copy() for x in (spectrum.values, spectrum.along(rows), spectrum.along(u)))
    squares = np.sum(y**2, axis=0)
    # Sums over the m rows run over the poses of an array (3, m, N), in a tenth of the time of sums over its last axis.
    products = np.stack([y**2, y * z, z**2])
    scaled = values * products
    starts = np.log([spectrum.typical, 1.0 / max(float(np.median(squares[squares > 0])), 1e-300)])

    def cost(logs: Array) -> tuple[float, Array]:
        """Return minus the log likelihood, less a constant, and its derivatives by the logarithms of v and w."""
        v, w = np.exp(logs)
        D = 1.0 + v * values
        # The determinant and the inverse of a matrix with a term of rank one (Sherman and Morrison, Ann. Math. Stat. 21, 1950).
        a, b, c = (products / D).sum(axis=1)
        da, db, dc = -(scaled / D**2).sum(axis=1)
        s = 1.0 + w * a
        value = 0.5 * float(np.sum(np.log(D)) + np.sum(np.log(s) + c - w * b**2 / s))
        by_v = np.sum(values / D) + np.sum(w * da / s + dc - 2.0 * w * b * db / s + (w * b / s) ** 2 * da)
        by_w = np.sum(a / s - (b / s) ** 2)
        return value, 0.5 * np.array([v * by_v, w * by_w])

    bounds = [(start + _POWERS[0], start + _POWERS[1]) for start in starts]
    tries: list[Any] = [
        minimize(cost, starts + shift, jac=True, method="L-BFGS-B", bounds=bounds)
        for shift in ((0.0, 0.0), (-4.0, 4.0))
    ]
    best = min(tries, key=lambda found: float(found.fun))
    v, w = np.exp(best.x)
    information = _expected_information(values.T, y.T, v, w)
    gain = 0.5 * float(np.sum(z**2)) - float(best.fun)
    return TwoVariances(gain, np.array([v, w]), np.linalg.pinv(information, hermitian=True))


def _expected_information(values: Array, y: Array, v: float, w: float) -> Array:
    """Return ``1/2 tr(V^-1 K_a V^-1 K_b)`` ``(2, 2)``, from the eigenvalues ``(N, m)`` of K and the components ``(N, m)`` of u along its vectors."""
    D = 1.0 + v * values
    q = y / D
    s = 1.0 + w * np.sum(y * q, axis=1)
    share = w / s
    along = np.sum(values * q**2, axis=1)
    of_v = (
        np.sum((values / D) ** 2, axis=1)
        - 2.0 * share * np.sum(values**2 * q**2 / D, axis=1)
        + (share * along) ** 2
    )
    of_w = (np.sum(y * q, axis=1) / s) ** 2
    both = along / s**2
    return 0.5 * np.array([[np.sum(of_v), np.sum(both)], [np.sum(both), np.sum(of_w)]])
