"""Standard deviations that outliers hardly change."""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

MAD_TO_STD = 1.4826  # of normally distributed errors: 1 / 0.6745, the inverse of their upper quartile


def robust_std(deviations: Array) -> float:
    """Return ``1.4826 median(|x|)``, the standard deviation of normally distributed deviations ``(N,)`` about zero.

    Up to half of the deviations may be arbitrarily wrong (Rousseeuw and Croux, 1993).
    """
    return MAD_TO_STD * float(np.median(np.abs(deviations)))
