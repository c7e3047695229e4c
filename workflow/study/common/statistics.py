"""Statistics over the seeds: which errors are summarised, and by which numbers."""

from __future__ import annotations

import numpy as np

QUANTITIES = ("position_mean_mm", "position_max_mm", "orientation_mean_deg", "orientation_max_deg")
"""Columns of errors.csv that are summarised."""

STATISTICS = ("mean", "std", "min", "p05", "median", "p95", "max")
"""Columns of summary.csv over the seeds, in the unit in the quantity's name."""

BAND = (0.05, 0.95)
"""Quantiles over the seeds between which a band is drawn."""


def spread(values: np.ndarray) -> dict[str, float]:
    """Return the STATISTICS of values ``(S,)``; NaN where there are none."""
    if not len(values):
        return dict.fromkeys(STATISTICS, float("nan"))
    low, median, high = np.quantile(values, [BAND[0], 0.5, BAND[1]])
    std = float(values.std(ddof=1)) if len(values) > 1 else float("nan")
    return {
        "mean": float(values.mean()),
        "std": std,
        "min": float(values.min()),
        "p05": float(low),
        "median": float(median),
        "p95": float(high),
        "max": float(values.max()),
    }
