"""Whether positions differ by more than chance explains, whatever parameters two calibrations share."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

_LEAST_TIMES = 1.54  # the bound on a sum of squares (``is_beyond_chance``) holds for x above this
_LEAST = 1e-9  # m; rounding makes a smaller difference between two equal models


def is_beyond_chance(rms: float, by_chance: float, alpha: float) -> bool:
    """Return whether a root mean square difference of positions is beyond chance.

    The squared difference is a weighted sum of squares of normal numbers. Whatever the weights, it exceeds x times its mean, x > 1.54,
    at most as often as a single square does (Szekely and Bakirov, Probability Theory and Related Fields 126 (2003)).

    Args:
        rms: The difference [m].
        by_chance: What chance alone makes of it [m], root mean square.
        alpha: Probability of being called beyond chance where nothing changed.
    """
    return rms > most_by_chance(by_chance, alpha)


def most_by_chance(by_chance: float, alpha: float) -> float:
    """Return the root mean square difference [m] that chance exceeds with a probability of at most ``alpha``, arguments as above."""
    times = max(float(chi2.isf(alpha, 1)), _LEAST_TIMES)
    return max(float(np.sqrt(times)) * by_chance, _LEAST)
