"""Summarise the errors with planned and with random poses over the seeds, and compare them in the same seed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from study.planning.compare import PLANNED, RANDOM


def summarise_planning(errors: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each way and number of poses: medians and quartiles of the mean position error over the seeds, and failures."""
    rows: list[dict[str, Any]] = []
    table: Any = errors
    for (way, poses), group in table.groupby(["way", "poses"], sort=True):
        done: Any = group[group["status"] == "calibrated"]
        low, middle, high = np.quantile(done["position_mean_mm"], [0.25, 0.5, 0.75])
        rows.append(
            {
                "way": way,
                "poses": poses,
                "seeds": len(group),
                "failed": len(group) - len(done),
                "position_mean_mm_median": middle,
                "position_mean_mm_lower_quartile": low,
                "position_mean_mm_upper_quartile": high,
                "position_max_mm_median": done["position_max_mm"].median(),
                "position_rms_mm": float(np.sqrt(np.mean(done["position_rms_mm"] ** 2))),
                "expected_error_mm_median": done["expected_error_mm"].median(),
            }
        )
    return pd.DataFrame(rows)


def errors_by_way(rows: list[dict[Any, Any]]) -> dict[str, dict[str, float]]:
    """Return the errors [mm] of rows of ``summarise_planning`` as the paper quotes them, by way and number of poses."""
    quoted = {
        "median_mm": "position_mean_mm_median",
        "lower_quartile_mm": "position_mean_mm_lower_quartile",
        "upper_quartile_mm": "position_mean_mm_upper_quartile",
        "rms_mm": "position_rms_mm",
        "expected_mm": "expected_error_mm_median",
    }
    return {
        f"{row['way']}_{row['poses']}": {name: float(row[column]) for name, column in quoted.items()}
        for row in rows
    }


def planning_numbers(errors: pd.DataFrame) -> dict[str, Any]:
    """Return the errors of each way and number of poses, and for each two numbers how planned poses compare with random ones in the same seed.

    ``errors`` are those of ``summarise_planning``. ``times_random`` is the median ratio of the mean position error with planned poses to that with
    random ones, ``better_in`` the number of seeds in which the planned poses have the smaller error, and ``p_value`` that of the two-sided sign test.
    """
    calibrated: Any = errors[errors["status"] == "calibrated"]
    done = calibrated.set_index(["way", "poses", "seed"])["position_mean_mm"].sort_index()
    sizes = sorted({int(n) for n in errors["poses"]})
    rows = summarise_planning(errors).to_dict("records")
    numbers: dict[str, Any] = {
        "seeds": len(set(errors["seed"])),
        "poses": sizes,
        "errors": errors_by_way(rows),
    }
    for planned in sizes:
        for random in sizes:
            ratio = (done[PLANNED, planned] / done[RANDOM, random]).dropna()
            better = int((ratio < 1).sum())
            numbers[f"planned_{planned}_against_random_{random}"] = {
                "times_random": float(ratio.median()),
                "better_in": better,
                "seeds": len(ratio),
                "p_value": float(binomtest(better, len(ratio)).pvalue),
            }
    return numbers
