"""The tables of a sweep: the errors of all its cases, and their statistics over the seeds for each point of a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from study.common.methods import BOUND, CONVERGED, EFFICIENT, INITIAL
from study.common.statistics import QUANTITIES, summary_statistics

LOST_MM = 5.0
"""Mean position error [mm] beyond which a fit that says it converged has found another solution."""

PLACED_COLUMNS = [
    *("walls", "method", "value", "quantity", "published"),
    *("simulated_min", "simulated_p05", "simulated_median", "simulated_p95", "simulated_max"),
    *("inside_band", "inside_range", "percentile", "seeds"),
]
"""Columns of the table that says where published points fall among the simulated ones."""


def join_cases(tables: Sequence[pd.DataFrame], values: Mapping[str, float]) -> pd.DataFrame:
    """Return the tables of groups of cases as one, ordered by walls, with the value of each case on the axis.

    Args:
        tables: As ``sweep_cases`` returns them.
        values: ``{case: value on the axis, in the unit of its label}``.
    """
    parts = [table.dropna(axis=1, how="all") for table in tables]
    whole = pd.concat(parts, ignore_index=True).reindex(columns=list(tables[0].columns))
    whole.insert(1, "value", [values[case] for case in whole["case"]])
    order = {name: k for k, name in enumerate(dict.fromkeys(whole["walls"]))}
    return whole.sort_values("walls", kind="stable", key=lambda names: names.map(order), ignore_index=True)


def summarise_sweep(errors: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each kind of walls, case, method, alignment and quantity: how the fits ended, and statistics of those that converged.

    ``failed`` counts every fit that did not converge. Among these, ``refused`` ones have no model, ``raised`` ones met a NaN, and ``capped`` ones
    reached the largest number of evaluations. ``lost`` counts fits that converged farther than ``LOST_MM`` from the truth; they stay in the
    statistics. The columns from ``mean`` on are in the unit in the quantity's name.
    """
    rows: list[dict[str, Any]] = []
    by: Any = ["walls", "case", "value", "method", "alignment"]
    table: Any = errors
    for key, group in table.groupby(by, sort=False):
        status = group["status"]
        ended = group[status.isin([CONVERGED, INITIAL, BOUND, EFFICIENT])]
        lost = (ended["position_mean_mm"] > LOST_MM) & (ended["status"] == CONVERGED)
        counts = {
            "seeds": len(group),
            "failed": len(group) - len(ended),
            "refused": int(group["position_mean_mm"].isna().sum()),
            "raised": int((status == "raised").sum()),
            "capped": int((status == "capped").sum()),
            "lost": int(lost.sum()),
        }
        for quantity in QUANTITIES:
            values = ended[quantity].to_numpy(dtype=float)
            rows.append(
                dict(zip(by, key, strict=True)) | {"quantity": quantity} | counts | summary_statistics(values)
            )
    return pd.DataFrame(rows)


def place_published_curve(errors: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Return where every published point falls among the raw errors of the fits that converged: a row for each walls, method, point and quantity.

    ``inside_band`` says whether it lies between the 5 and 95 % quantiles over the seeds, ``inside_range`` whether it lies
    between the least and the greatest; ``percentile`` is the share of the seeds below it, in per cent.

    Args:
        errors: errors.csv of the sweep.
        published: Rows of published_curves.csv of that sweep.
    """
    rows: list[dict[str, Any]] = []
    converged: Any = errors[(errors["alignment"] == "raw") & (errors["status"] == CONVERGED)]
    for (walls, method), group in converged.groupby(["walls", "method"], sort=False):
        for point in published.to_dict("records"):
            here = group[(group["value"] - point["value"]).abs() <= 1e-9 * abs(point["value"])]
            for quantity in QUANTITIES:
                values = here[quantity].to_numpy(dtype=float)
                if not len(values):
                    continue
                value, over = float(point[quantity]), summary_statistics(values)
                rows.append(
                    {
                        "walls": walls,
                        "method": method,
                        "value": point["value"],
                        "quantity": quantity,
                        "published": value,
                        **{
                            f"simulated_{name}": over[name] for name in ("min", "p05", "median", "p95", "max")
                        },
                        "inside_band": bool(over["p05"] <= value <= over["p95"]),
                        "inside_range": bool(over["min"] <= value <= over["max"]),
                        "percentile": 100.0 * float((values < value).mean()),
                        "seeds": len(values),
                    }
                )
    return pd.DataFrame(rows, columns=PLACED_COLUMNS)
