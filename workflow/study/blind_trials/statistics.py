"""Intervals of shares, and the size of an effect at which half of the sets are named right."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.stats import norm

from scalar.geometry.se3 import Array

LEVEL = 0.95  # confidence level of all intervals
DRAWS = 400  # draws of the bootstrap of half points
CLUSTER_DRAWS = 4000  # draws of the bootstrap of shares, which takes little time
_SEED = 20_261_121


def wilson(successes: int, trials: int, level: float = LEVEL) -> tuple[float, float]:
    """Return the confidence interval of a share of independent trials (E. B. Wilson, 1927); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    z = norm.ppf(0.5 + level / 2)
    share = successes / trials
    centre = share + z * z / (2 * trials)
    half = z * np.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    # Without successes the lower end is exactly 0, and without failures the upper end is exactly 1; rounding would change them.
    low = float((centre - half) / scale) if successes > 0 else 0.0
    high = float((centre + half) / scale) if successes < trials else 1.0
    return low, high


def clustered_interval(hits: Array, groups: Sequence[object], level: float = LEVEL) -> tuple[float, float]:
    """Return the confidence interval of a share over sets of which several have the same scene, by drawing whole scenes anew (bootstrap of clusters).

    Sets of one scene have poses and noise in common and are no independent trials. Wilson's interval is then too narrow, or too wide if the shares
    of the scenes differ less than by chance. If all sets are hits, or none is, all draws are equal; the interval is then Wilson's for one trial per
    scene.

    Args:
        hits: ``(n,)``, 1 for each set that counts and 0 for the others.
        groups: ``(n,)``, the scene of each set.
        level: Confidence level.
    """
    names, member = np.unique(np.array([str(group) for group in groups]), return_inverse=True)
    hits = np.asarray(hits, dtype=float)
    if len(names) == 0 or hits.min() == hits.max():
        return wilson(int(len(names) * hits[:1].sum()), len(names), level)
    right, tried = np.bincount(member, weights=hits), np.bincount(member).astype(float)
    chosen = np.random.default_rng(_SEED).integers(len(names), size=(CLUSTER_DRAWS, len(names)))
    shares = right[chosen].sum(axis=1) / tried[chosen].sum(axis=1)
    low, high = np.quantile(shares, [0.5 - level / 2, 0.5 + level / 2])
    return float(low), float(high)


def half_point(x: Array, found: Array) -> float:
    """Return the x at which the share of hits, assumed to rise with x, reaches one half; NaN if it never does.

    The shares are those of isotonic regression, and log x is interpolated between the values that were tried. If the share is one half or more at the
    smallest value tried, 0 is returned.

    Args:
        x: ``(k,)``, size of each trial, positive.
        found: ``(k,)``, 1 for a hit and 0 otherwise.
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
    """Return the confidence interval of ``half_point`` by drawing whole groups anew; its upper end is NaN if it lies beyond the largest value tried.

    Args:
        x: ``(k,)``, as in ``half_point``.
        found: ``(k,)``, as in ``half_point``.
        groups: ``(k,)``, the scene (workcell and seed) of each trial.
        level: Confidence level.
    """
    names, member = np.unique(np.array([str(group) for group in groups]), return_inverse=True)
    rows = [np.flatnonzero(member == i) for i in range(len(names))]
    rng = np.random.default_rng(_SEED)
    drawn = []
    for _ in range(DRAWS):
        chosen = np.concatenate([rows[i] for i in rng.integers(len(rows), size=len(rows))])
        drawn.append(half_point(x[chosen], found[chosen]))
    # If the share of a draw never reaches one half, its half point lies beyond the largest value.
    drawn = np.where(np.isnan(drawn), np.inf, drawn)
    low, high = np.quantile(drawn, [0.5 - level / 2, 0.5 + level / 2], method="nearest")
    return float(low), float(high if np.isfinite(high) else np.nan)
