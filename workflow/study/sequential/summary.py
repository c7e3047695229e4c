"""Summarise the comparison of orders over the seeds: the errors, and their ratios to those of the fit of all parameters at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import CONVERGED, INITIAL
from study.common.statistics import BAND, QUANTITIES, STATISTICS, summary_statistics
from study.sequential.compare import AT_ONCE, ORDERS

STAGES = ("before", "at_once", "one_pass", "alternating")
"""``one_pass``: each block fitted once; ``alternating``: where repeated passes end."""
CASE_COLUMNS = ["case", "poses", "noise_mm", "length_error_mm", "angle_error_deg"]


def staged(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the rows that are compared, with the column ``stage``: a row for each case, seed, way, stage and alignment."""
    single: Any = errors[errors["way"].isin([INITIAL, AT_ONCE])]
    ordered: Any = errors[errors["way"].isin(ORDERS)]
    goes_on = ordered.groupby(["case", "way"])["passes"].transform("max") > 1
    stage = single["way"].map({INITIAL: "before", AT_ONCE: "at_once"})
    return pd.concat(
        [
            single.assign(stage=stage),
            ordered[ordered["passes"] <= 1].assign(stage="one_pass"),  # 0: failed
            ordered[ordered["last"] & goes_on].assign(stage="alternating"),
        ],
        ignore_index=True,
    )


def summarise_sequential(errors: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each case, way, stage, alignment and quantity.

    ``mean`` to ``max`` are over the seeds, in the unit in the quantity's name. ``times_at_once_*`` is the error divided by that of the fit of all at
    once with the same seed, ``worse_than_at_once`` the share of seeds in which it is larger. ``passes_*`` are numbers of passes; ``not_converged``
    counts the seeds in which the largest number of passes was reached, ``failed`` those in which the model could not be determined.
    """
    rows: list[dict[str, Any]] = []
    table: Any = staged(errors)
    for key, group in table.groupby([*CASE_COLUMNS, "way", "stage", "alignment"], sort=False):
        case, alignment = key[0], key[-1]
        reference = table[
            (table["case"] == case) & (table["way"] == AT_ONCE) & (table["alignment"] == alignment)
        ].set_index("seed")
        passes = group["passes"].to_numpy(dtype=float)
        common = dict(zip([*CASE_COLUMNS, "way", "stage", "alignment"], key, strict=True)) | {
            "seeds": len(group),
            "failed": int(group["position_mean_mm"].isna().sum()),
            "passes_median": float(np.median(passes)),
            "passes_max": int(passes.max()),
            "not_converged": int((group["status"] == "stopped").sum()),
        }
        for quantity in QUANTITIES:
            values = group.set_index("seed")[quantity].dropna()
            times = (values / reference[quantity]).dropna().to_numpy(dtype=float)
            low, middle, high = (
                np.quantile(times, [BAND[0], 0.5, BAND[1]]) if len(times) else (np.nan, np.nan, np.nan)
            )
            rows.append(
                common
                | {"quantity": quantity}
                | summary_statistics(values.to_numpy(dtype=float))
                | {
                    "times_at_once_p05": float(low),
                    "times_at_once_median": float(middle),
                    "times_at_once_p95": float(high),
                    "worse_than_at_once": float((times > 1).mean()) if len(times) else np.nan,
                }
            )
    return pd.DataFrame(rows)


def sequential_numbers(errors: pd.DataFrame, summary: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers that the paper quotes, of raw errors only: ``cases[case]["ways"][way][stage][quantity]``.

    ``times_at_once`` and ``worse_than_at_once`` are entries of a stage too, each with a value for every quantity.

    ``pass_leaves`` is the share of the error that a pass leaves near the joint optimum, as the Jacobian predicts it.
    """
    cases: dict[str, Any] = {}
    raw: Any = summary[summary["alignment"] == "raw"]
    for row in raw.to_dict("records"):
        case = cases.setdefault(row["case"], {name: row[name] for name in CASE_COLUMNS[1:]} | {"ways": {}})
        entry = (
            case["ways"]
            .setdefault(row["way"], {})
            .setdefault(
                row["stage"],
                {
                    name: row[name]
                    for name in ("seeds", "failed", "passes_median", "passes_max", "not_converged")
                },
            )
        )
        entry[row["quantity"]] = {name: row[name] for name in STATISTICS}
        of_what = row["quantity"].rsplit("_", 1)[0]  # ratios and shares have no unit
        entry.setdefault("times_at_once", {})[of_what] = {
            name: row[f"times_at_once_{name}"] for name in ("p05", "median", "p95")
        }
        entry.setdefault("worse_than_at_once", {})[of_what] = row["worse_than_at_once"]
    for name, case in cases.items():
        rates: Any = errors[
            (errors["case"] == name) & (errors["way"] == AT_ONCE) & (errors["status"] == CONVERGED)
        ]
        case["pass_leaves"] = summary_statistics(rates.drop_duplicates("seed")["rate"].to_numpy(dtype=float))
    return {"cases": cases}
