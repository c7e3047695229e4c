"""Compare the headline's errors between processors: how far means over seeds and single seeds differ.

Rounding changes the last digits of every calibration. Where it changes the path of the iterations, results differ visibly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import CONVERGED, INITIAL
from study.headline.summary import QUANTITIES

COMPARED = (*QUANTITIES, "predicted_position_std_mean_mm", "residual_rms_mm", "evaluations")
"""Columns of errors.csv that are compared, raw errors only."""


def compare_processors(tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return how far processors differ: a row for each method and quantity.

    A difference is the largest value over the processors less the smallest, divided by their mean; columns ``mean``, of the
    mean over seeds; ``single_seed``, the largest of any seed; ``median_seed``; ``seeds_differing``, the seeds with any
    difference at all; ``status_differing``, the seeds in which the fit ends otherwise; ``lowest_mean``, ``highest_mean`` in the
    quantity's unit. A seed counts for a quantity if it has a number on every processor.

    Args:
        tables: ``{processor: errors.csv}``, the same seeds and methods in each.
    """
    columns: list[str] = ["processor", "seed", "method", "status", *COMPARED]
    joined = pd.concat([table.assign(processor=name) for name, table in tables.items()], ignore_index=True)
    raw: Any = joined[(joined["alignment"] == "raw") & (joined["method"] != INITIAL)][columns]
    rows = []
    for method, of_method in raw.groupby("method", sort=False):
        endings: Any = of_method.pivot(index="seed", columns="processor", values="status")
        for quantity in COMPARED:
            wide: Any = of_method.pivot(index="seed", columns="processor", values=quantity).dropna()
            values = wide.to_numpy(dtype=float)
            if not len(values):
                continue
            seeds, means = relative_range(values), values.mean(axis=0)
            rows.append(
                {
                    "method": method,
                    "quantity": quantity,
                    "seeds": len(values),
                    "mean": float(relative_range(means[None])[0]),
                    "single_seed": float(seeds.max()),
                    "median_seed": float(np.median(seeds)),
                    "seeds_differing": int(np.count_nonzero(seeds)),
                    "status_differing": int(np.count_nonzero(endings.nunique(axis=1).to_numpy() > 1)),
                    "lowest_mean": float(means.min()),
                    "highest_mean": float(means.max()),
                }
            )
    return pd.DataFrame(rows)


def relative_range(values: np.ndarray) -> np.ndarray:
    """Return ``(max - min) / |mean|`` along each row ``(S, K)``, ``(S,)``; 0 where all are the same."""
    range_ = np.ptp(values, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(range_ == 0.0, 0.0, range_ / np.abs(values.mean(axis=1)))


def processor_numbers(tables: Mapping[str, pd.DataFrame], compared: pd.DataFrame) -> dict[str, Any]:
    """Return what a text quotes: processors, seeds, and by method and quantity the differences of ``compare_processors``.

    ``different`` counts the sets of results that differ from one another: two processors with the same kernels count once.
    ``converged`` gives the seeds that converge on every processor.
    """
    methods: dict[str, Any] = {}
    for method, rows in compared.groupby("method", sort=False):
        entries: Any = rows.to_dict("records")
        methods[str(method)] = {
            _unitless(entry["quantity"]): {
                name: entry[name]
                for name in ("mean", "single_seed", "median_seed", "seeds_differing", "status_differing")
            }
            for entry in entries
        } | {"converged": min(_converged(table, str(method)) for table in tables.values())}
    contents = {table.to_csv(index=False) for table in tables.values()}
    first = next(iter(tables.values()))
    return {
        "processors": list(tables),
        "different": len(contents),
        "seeds": len(set(first["seed"])),
        "methods": methods,
    }


def _unitless(quantity: str) -> str:
    """Return a quantity's name without its unit: its differences are shares and have none."""
    stem, _, unit = quantity.rpartition("_")
    return stem if unit in ("mm", "deg") else quantity


def _converged(table: pd.DataFrame, method: str) -> int:
    rows: Any = table[(table["method"] == method) & (table["alignment"] == "raw")]
    return int(np.count_nonzero(rows["status"] == CONVERGED))
