"""Shares with intervals, the size at which half is found, and how sure answers ought to be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.stats import norm

from scalar.geometry.se3 import Array

LEVEL = 0.95  # of all intervals
DRAWS = 400  # of the bootstrap
_SEED = 20_261_121


def wilson(successes: int, trials: int, level: float = LEVEL) -> tuple[float, float]:
    """Return the interval of a share (E. B. Wilson, 1927); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    z = norm.ppf(0.5 + level / 2)
    share = successes / trials
    centre = share + z * z / (2 * trials)
    half = z * np.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    return max(0.0, float((centre - half) / scale)), min(1.0, float((centre + half) / scale))


def half_point(x: Array, found: Array) -> float:
    """Return the x at which the share found, taken to rise with x, passes one half; NaN where it never does.

    The shares are those of isotonic regression, and log x is interpolated between the values that were tried.
    A share above one half everywhere gives 0: smaller values were not tried.

    Args:
        x: ``(k,)``, positive. found: ``(k,)`` of 0 and 1.
    """
    values, place = np.unique(x, return_inverse=True)
    tried = np.bincount(place).astype(float)
    share = np.bincount(place, weights=found) / tried
    rising = isotonic_regression(share, weights=tried).x
    if rising[-1] < 0.5:
        return float("nan")
    k = int(np.argmax(rising >= 0.5))
    if k == 0:
        return 0.0
    t = (0.5 - rising[k - 1]) / (rising[k] - rising[k - 1])
    return float(np.exp((1 - t) * np.log(values[k - 1]) + t * np.log(values[k])))


def half_point_interval(
    x: Array, found: Array, groups: Sequence[object], level: float = LEVEL
) -> tuple[float, float]:
    """Return the interval of ``half_point`` by drawing whole groups (seeds) anew; NaN where no half was reached."""
    names, member = np.unique(np.array([str(group) for group in groups]), return_inverse=True)
    rows = [np.flatnonzero(member == i) for i in range(len(names))]
    rng = np.random.default_rng(_SEED)
    drawn = []
    for _ in range(DRAWS):
        chosen = np.concatenate([rows[i] for i in rng.integers(len(rows), size=len(rows))])
        drawn.append(half_point(x[chosen], found[chosen]))
    # A draw that never passes one half lies beyond the largest value, not nowhere.
    drawn = np.where(np.isnan(drawn), np.inf, drawn)
    low, high = np.quantile(drawn, [0.5 - level / 2, 0.5 + level / 2], method="nearest")
    return float(low), float(high if np.isfinite(high) else np.nan)
