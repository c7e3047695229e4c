"""The size of a scan's noise as a function of its range and of the incidence of its rays.

``log g^2 = b_0 + b_1 ln(r / r_0) + b_2 ln^2(r / r_0) + b_3 ln |n . e|``, with g the noise of a scan relative to the assumed one, r_0 the median
range, and ``n . e`` the product of the plane's normal and the direction in which the scanner errs: noise may grow with the range, and with the
slant of the surface by more than noise along the ray does. The mean square ``s^2`` of a scan with nu degrees of freedom has
``E log s^2 = log g^2 - 1 / nu`` and ``var log s^2 = 2 / nu`` (Bartlett and Kendall, JRSS Supplement 8, 1946, to first order). Outlying
scans are trimmed, and a scatter of the others beyond that variance counts as overdispersion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from scalar.geometry.se3 import Array
from scalar.sensors.robust_scale import robust_std
from scalar.sensors.within_scan_noise.profiles import Profiles

_ROUNDS = 5  # rounds of trimming; more would change nothing
_TRIMMED = 4.0
"""Robust standard deviations beyond which a scan is trimmed: one normal scan in sixteen thousand."""
_RIDGE = 1e-6  # keeps the coefficient of a variable that does not vary at zero


@dataclass(frozen=True, eq=False)
class Level:
    """The regression of the logarithm of the scans' noise.

    Attributes:
        coefficients: ``(4,)``, b.
        covariance: ``(4, 4)``, of b, overdispersion included.
        p_varies: p-value of the hypothesis that all scans have the same noise.
        p_stated: p-value of the hypothesis that the noise of a typical scan is as stated.
        variance: ``(N,)``, g^2 of each scan, clipped to the range of the scans to which the regression was fitted.
    """

    coefficients: Array
    covariance: Array
    p_varies: float
    p_stated: float
    variance: Array

    @classmethod
    def of(cls, profiles: Profiles, mean_square: Array, freedom: Array, use: Array) -> Level:
        """Return the regression of the scans' noise.

        Args:
            profiles: The scans.
            mean_square: ``(N,)``, s^2 of each scan.
            freedom: ``(N,)``, its degrees of freedom nu.
            use: ``(N,)`` bool, the scans to which the regression is fitted.
        """
        log_range = profiles.log_range - np.median(profiles.log_range[use])
        z = np.column_stack([np.ones_like(log_range), log_range, log_range**2, profiles.log_incidence])
        design, weight = z[use], freedom[use] / 2.0
        observed = np.log(mean_square[use]) + 1.0 / freedom[use]
        keep = np.ones(len(design), dtype=bool)
        b, H, off = np.zeros(4), np.eye(4), np.zeros(len(design))
        for _ in range(_ROUNDS):
            weighted = design[keep] * weight[keep, None]
            H = weighted.T @ design[keep] + _RIDGE * np.eye(4)
            b = np.linalg.solve(H, weighted.T @ observed[keep])
            off = (observed - design @ b) * np.sqrt(weight)
            typical = max(robust_std(off - np.median(off)), 1.0)
            keep = np.abs(off) < _TRIMMED * typical
        excess = max(float(np.sum(off[keep] ** 2)) / max(int(keep.sum()) - 4, 1), 1.0)
        fitted = design @ b
        variance = np.exp(np.clip(z @ b, fitted.min(), fitted.max()))
        covariance = excess * np.linalg.inv(H)
        slopes = float(b[1:] @ np.linalg.solve(covariance[1:, 1:], b[1:]))
        middle = np.mean(design[keep], axis=0)
        stated = float((middle @ b) ** 2 / (middle @ covariance @ middle))
        return cls(b, covariance, float(chi2.sf(slopes, 3)), float(chi2.sf(stated, 1)), variance)

    def constant(self) -> Level:
        """Return the level with the same noise for all scans, the geometric mean of theirs."""
        same = np.full_like(self.variance, float(np.exp(np.mean(np.log(self.variance)))))
        return replace(self, coefficients=np.r_[np.log(same[0]), 0.0, 0.0, 0.0], variance=same)
