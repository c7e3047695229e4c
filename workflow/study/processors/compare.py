"""Compare the errors of the main study between processors: how far means over seeds and single seeds differ.

Processors round differently, which changes the last digits of every calibration. If an iteration then takes another path, results differ visibly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import CONVERGED, INITIAL
from study.headline.summary import QUANTITIES

COMPARED = (*QUANTITIES, "predicted_position_std_mean_mm", "residual_rms_mm", "evaluations")
"""Columns of errors.csv that are compared, in the rows of raw errors."""


def compare_processors(tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return how far processors differ: a row for each method and quantity.

    A difference is the largest value over the processors minus the smallest, divided by the absolute value of their mean. A seed counts for a
    quantity if it has a number on every processor.

    Args:
        tables: ``{processor: errors.csv}``, the same seeds and methods in each.

    Returns:
        Columns ``method``, ``quantity`` and ``seeds`` (their number); ``mean``, the difference of the means over seeds; ``single_seed`` and
        ``median_seed``, the largest and the median difference of a seed; ``seeds_differing``, the number of seeds with any difference;
        ``status_differing``, the number of seeds whose fits do not end with the same status; and ``lowest_mean`` and ``highest_mean``, the
        means over seeds in the quantity's unit.
    """
    columns: list[str] = ["processor", "seed", "method", "status", *COMPARED]
    joined = pd.concat([table.assign(processor=name) for name, table in tables.items()], ignore_index=True)
    raw: Any = joined[(joined["alignment"] == "raw") & (joined["method"] != INITIAL)][columns]
    rows = []
    for method, of_method in raw.groupby("method", sort=False):
        statuses: Any = of_method.pivot(index="seed", columns="processor", values="status")
        for quantity in COMPARED:
            wide: Any = of_method.pivot(index="seed", columns="processor", values=quantity).dropna()
            values = wide.to_numpy(dtype=float)
            if not len(values):
                continue
            differences, means = relative_range(values), values.mean(axis=0)
            rows.append(
                {
                    "method": method,
                    "quantity": quantity,
                    "seeds": len(values),
                    "mean": float(relative_range(means[None])[0]),
                    "single_seed": float(differences.max()),
                    "median_seed": float(np.median(differences)),
                    "seeds_differing": int(np.count_nonzero(differences)),
                    "status_differing": int(np.count_nonzero(statuses.nunique(axis=1).to_numpy() > 1)),
                    "lowest_mean": float(means.min()),
                    "highest_mean": float(means.max()),
                }
            )
    return pd.DataFrame(rows)


def relative_range(values: np.ndarray) -> np.ndarray:
    """Return ``(max - min) / |mean|`` ``(S,)`` of each row of ``values`` ``(S, K)``; 0 for a row of equal values."""
    range_ = np.ptp(values, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(range_ == 0.0, 0.0, range_ / np.abs(values.mean(axis=1)))


def processor_numbers(tables: Mapping[str, pd.DataFrame], compared: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers that the paper quotes: processors, seeds, and by method and quantity the differences of ``compare_processors``.

    ``different`` is the number of different tables: two processors with the same kernels count once. ``converged`` is the number of seeds that
    converge, on the processor on which the fewest do.

    Args:
        tables: ``{processor: errors.csv}``.
        compared: As ``compare_processors`` returns it.
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
    """Return a quantity's name without its unit, since relative differences have none."""
    stem, _, unit = quantity.rpartition("_")
    return stem if unit in ("mm", "deg") else quantity


def _converged(table: pd.DataFrame, method: str) -> int:
    """Return the number of seeds with which a method converges."""
    rows: Any = table[(table["method"] == method) & (table["alignment"] == "raw")]
    return int(np.count_nonzero(rows["status"] == CONVERGED))
