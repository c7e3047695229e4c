"""Statistics over the seeds: which errors are summarised, and by which numbers."""

from __future__ import annotations

import numpy as np

QUANTITIES = ("position_mean_mm", "position_max_mm", "orientation_mean_deg", "orientation_max_deg")
"""Columns of errors.csv that are summarised."""

POSE_ERROR_COLUMNS = {
    "status": "converged, or how the fit ended; a row without numbers has no calibration",
    "alignment": "raw: poses as predicted; aligned: after the best rigid motion of the base",
    "position_mean_mm": "mean position error over the evaluation poses (equation 18 of the original paper)",
    "position_max_mm": "the largest of them",
    "orientation_mean_deg": "mean angle of the error rotation over the evaluation poses",
    "orientation_max_deg": "the largest of them",
}
"""Columns that every table of errors over the evaluation poses has, with their meanings."""

STATISTICS = ("mean", "std", "min", "p05", "median", "p95", "max")
"""Columns of summary.csv over the seeds, in the unit in the quantity's name."""

BAND = (0.05, 0.95)
"""Quantiles over the seeds between which a band is drawn."""


def summary_statistics(values: np.ndarray) -> dict[str, float]:
    """Return the STATISTICS of values over the seeds ``(S,)``; NaN where there are none."""
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
