"""Summaries of the study of coverage: the share of ellipsoids that hold the true position, for each combination and region."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.statistics import clustered_interval
from study.common.provenance import code_version, design_identity

KEYS = ("sensor", "size", "prior")
ALL = "all"  # in the columns of ``KEYS`` and ``region``


def coverage(rows: Any) -> pd.DataFrame:
    """Return a row for each combination of sensor, size and prior, and one for all, in each region and in both.

    Columns: ``sensor``, ``size``, ``prior``, ``region``, ``workcells``, ``failed`` (that have no calibration), ``predicted`` poses, how many are
    ``held``, their ``share`` with its 95 % interval ``low`` to ``high``, which is that of whole workcells drawn anew, and the medians of the RMS of
    errors and of stated standard errors [mm].
    """
    groups = [(key, group) for key, group in rows.groupby(list(KEYS), sort=True)]
    groups += [((sensor, ALL, ALL), group) for sensor, group in rows.groupby("sensor")]
    table = []
    for key, group in [*groups, ((ALL, ALL, ALL), rows)]:
        for region in ("inside", "outside", ALL):
            own = group if region == ALL else group[group["region"] == region]
            table.append(dict(zip(KEYS, key, strict=True)) | {"region": region} | _counted(own))
    return pd.DataFrame(table)


def _counted(rows: Any) -> dict[str, Any]:
    """Return the columns of a row of ``coverage`` from the rows of its workcells."""
    ended = rows[rows["status"] == "calibrated"]
    predicted, held = ended["predicted"].astype(int), ended["held"].astype(int)
    hits = np.concatenate(
        [np.repeat([1, 0], [h, p - h]) for p, h in zip(predicted, held, strict=True)] or [[]]
    )
    low, high = clustered_interval(hits, np.repeat(ended["number"].to_numpy(), predicted).tolist())
    return {
        "workcells": rows["number"].nunique(),
        "failed": int(rows.loc[rows["status"] != "calibrated", "number"].nunique()),
        "predicted": int(predicted.sum()),
        "held": int(held.sum()),
        "share": float(held.sum() / max(predicted.sum(), 1)),
        "low": low,
        "high": high,
        "error_median_mm": float(ended["error_rms_mm"].median()),
        "std_median_mm": float(ended["std_rms_mm"].median()),
    }


def summarise_coverage(rows: Any, design: Mapping[str, Any]) -> tuple[dict[str, Any], pd.DataFrame]:
    """Return the numbers and the table of the study.

    Args:
        rows: Rows of all workcells, columns ``study.coverage.run.COLUMNS``.
        design: Content of the config.
    """
    table = coverage(rows)
    whole: Any = table[(table["sensor"] == ALL)]
    shares = {
        str(row["region"]): {name: float(row[name]) for name in ("share", "low", "high")}
        for row in whole.to_dict("records")
    }
    numbers = {
        "code": code_version(),
        "design": design_identity(design),
        "workcells": int(rows["number"].nunique()),
        "failed": int(whole["failed"].max()),
        "coverage": shares,
        "workcells_below_half": int(
            (rows["held"] < 0.5 * rows["predicted"]).groupby(rows["number"]).any().sum()
        ),
    }
    return numbers, table
