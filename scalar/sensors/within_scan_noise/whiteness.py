"""Whether the errors of a scan's points are independent: a test of the autocorrelation about each scan's own parabola.

With u the residuals about the parabola divided by their own standard deviation, ``S_k = sum u_i u_{i+k}`` over all scans. Each scan's share is
the quadratic form ``e' A_k e`` of the residuals ``e = P y``, over ``e' e / nu``, where P projects out the parabola, nu is the degrees of freedom and
A_k pairs the points that are k apart. If y is white and normal, such a ratio is independent of its denominator, so that its moments are known
exactly: with ``t_k = tr(P A_k)``,

    E S_k = t_k,    cov(S_j, S_k) = (t_j t_k + 2 tr(P A_j P A_k)) nu / (nu + 2) - t_j t_k

(Durbin and Watson, Biometrika 37, 1950). ``(S - E)' cov^-1 (S - E)`` over the first lags is about chi-squared: scans are many and independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from scalar.geometry.se3 import Array
from scalar.sensors.within_scan_noise.profiles import Profiles

LAGS = 8  # points; a longer correlation is significant at these lags too


@dataclass(frozen=True, eq=False)
class Whiteness:
    """The test of white noise.

    Attributes:
        correlation: ``(LAGS,)``, autocorrelation at lags 1 to LAGS, minus what the fit of parabolas causes.
        band: ``(LAGS,)``, its standard error if the noise is white.
        p_value: p-value of the hypothesis that the noise is white.
    """

    correlation: Array
    band: Array
    p_value: float


def whiteness(profiles: Profiles, residual: Array, trusted: Array) -> Whiteness:
    """Return the test of residuals about each scan's own parabola.

    Args:
        profiles: The scans.
        residual: ``(P,)``, residuals about the scans' own parabolas.
        trusted: ``(N,)`` bool, the scans to use.
    """
    scan, N = profiles.scan, len(profiles.starts) - 1
    freedom = np.maximum(profiles.counts - 3.0, 1.0)
    size = np.sqrt(profiles.sum(residual * residual) / freedom)
    use = trusted & (size > 0)
    u = residual / np.repeat(np.where(size > 0, size, 1.0), profiles.counts)
    S, pairs = np.zeros(LAGS), np.zeros(LAGS)
    trace = np.zeros((LAGS, N))  # tr(P A_k) of each scan
    smooth = np.zeros((LAGS, len(u), 3))  # A_k Q
    for k in range(1, LAGS + 1):
        same = (scan[k:] == scan[:-k]) & use[scan[k:]]
        S[k - 1], pairs[k - 1] = np.sum(u[k:] * u[:-k] * same), same.sum()
        overlap = np.sum(profiles.Q[k:] * profiles.Q[:-k], axis=1) * same
        trace[k - 1] = -np.bincount(scan[k:], overlap, N)
        smooth[k - 1, k:] += 0.5 * profiles.Q[:-k] * same[:, None]
        smooth[k - 1, :-k] += 0.5 * profiles.Q[k:] * same[:, None]
    # tr(P A_j P A_k) = tr(A_j A_k) - 2 tr(Q' A_j A_k Q) + tr(Q' A_j Q Q' A_k Q)
    inner = np.stack(
        [profiles.sum((profiles.Q[:, :, None] * s[:, None, :]).reshape(len(u), 9)) for s in smooth]
    )
    shrink = freedom / (freedom + 2.0)
    covariance = np.zeros((LAGS, LAGS))
    for j in range(LAGS):
        for k in range(j, LAGS):
            both = 0.5 * np.maximum(profiles.counts - (j + 1.0), 0.0) if j == k else 0.0
            twice = profiles.sum(np.einsum("pi,pi->p", smooth[j], smooth[k]))
            cross = np.sum(
                inner[j].reshape(N, 3, 3) * np.swapaxes(inner[k].reshape(N, 3, 3), 1, 2), axis=(1, 2)
            )
            form = both - 2.0 * twice + cross
            product = trace[j] * trace[k]
            covariance[j, k] = covariance[k, j] = np.sum(((product + 2.0 * form) * shrink - product)[use])
    off = S - trace.sum(axis=1)
    pairs = np.maximum(pairs, 1.0)
    statistic = float(off @ np.linalg.solve(covariance + 1e-9 * np.eye(LAGS), off))
    return Whiteness(
        off / pairs, np.sqrt(np.maximum(np.diag(covariance), 0.0)) / pairs, float(chi2.sf(statistic, LAGS))
    )
