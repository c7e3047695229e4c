"""Summarise the main study over its seeds: quantiles of the errors, normalised errors, and where published values fall among simulated ones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import CONVERGED, INITIAL
from study.common.statistics import QUANTITIES, STATISTICS, summary_statistics


def summarise_errors(errors: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each case, method, alignment and quantity: seeds, failures, mean, standard deviation, quantiles.

    The columns from ``mean`` on are in the unit in the quantity's name. Fits without a calibration are
    counted and left out; those that did not converge are counted and stay in, as they are.
    """
    rows = []
    for (case, method, alignment), group in _groups(errors, "case", "method", "alignment"):
        for quantity in QUANTITIES:
            values = group[quantity].dropna().to_numpy(dtype=float)
            rows.append(
                {
                    "case": case,
                    "method": method,
                    "alignment": alignment,
                    "quantity": quantity,
                    "seeds": len(group),
                    "not_converged": int((~group["status"].isin([CONVERGED, INITIAL])).sum()),
                    "without_calibration": len(group) - len(values),
                    **summary_statistics(values),
                }
            )
    return pd.DataFrame(rows)


def _groups(table: Any, *columns: str) -> Iterator[tuple[Any, Any]]:
    """Yield the key and the rows of each combination of values in the columns, in the order in which they first appear.

    The table has the type Any, because the type stubs of pandas do not distinguish a column from a table.
    """
    by: Any = list(columns)
    for key, rows in table.groupby(by, sort=False):
        yield (key if len(by) > 1 else key[0]), rows


def summarise_parameters(parameters: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each case, method and estimated parameter: the errors found, and the standard errors stated.

    ``normalized_rms`` is near 1 and ``within_2_std`` near 0.95 where the standard errors are true.
    """
    rows = []
    estimated: Any = parameters[parameters["std"].notna()]
    for (case, method, name), group in _groups(estimated, "case", "method", "parameter"):
        error, std = group["error"].to_numpy(dtype=float), group["std"].to_numpy(dtype=float)
        normalized = group["normalized_error"].to_numpy(dtype=float)
        rows.append(
            {
                "case": case,
                "method": method,
                "parameter": name,
                "unit": group["unit"].iloc[0],
                "truth": group["truth"].iloc[0],
                "seeds": len(group),
                "error_mean": error.mean(),
                "error_rms": np.sqrt(np.mean(error**2)),
                "std_mean": std.mean(),
                "normalized_mean": normalized.mean(),
                "normalized_rms": np.sqrt(np.mean(normalized**2)),
                "within_2_std": np.mean(np.abs(normalized) < 2.0),
            }
        )
    return pd.DataFrame(rows)


def summarise_planes(planes: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each case, method and plane: errors, and the share of seeds with errors within those that the original paper states.

    Args:
        planes: planes.csv.
        published: One row, ``distance_error_mm`` and ``normal_error_deg``.
    """
    distance_claim, normal_claim = (
        published["distance_error_mm"].iloc[0],
        published["normal_error_deg"].iloc[0],
    )
    rows = []
    for (case, method, plane), group in _groups(planes, "case", "method", "plane"):
        normal, distance = group["normal_error_deg"].abs(), group["distance_error_mm"].abs()
        rows.append(
            {
                "case": case,
                "method": method,
                "plane": plane,
                "seeds": len(group),
                "normal_error_rms_deg": np.sqrt(np.mean(normal**2)),
                "normal_error_max_deg": normal.max(),
                "distance_error_rms_mm": np.sqrt(np.mean(distance**2)),
                "distance_error_max_mm": distance.max(),
                "within_published": np.mean((normal <= normal_claim) & (distance <= distance_claim)),
            }
        )
    return pd.DataFrame(rows)


def place_published(errors: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Return where each published value falls among the simulated ones: a row for each method and quantity, raw errors only.

    ``percentile`` is the share of the seeds below the published value, in per cent: at 0 and 100 it lies outside
    the simulated range.

    Args:
        errors: errors.csv of one case.
        published: The published errors, with columns ``QUANTITIES`` and, in the column ``state``, rows ``initial`` and ``calibrated``.
    """
    states: Any = published.set_index("state")
    rows = []
    for method, group in _groups(errors[errors["alignment"] == "raw"], "method"):
        state = INITIAL if method == INITIAL else "calibrated"
        for quantity in QUANTITIES:
            simulated = group[quantity].dropna().to_numpy(dtype=float)
            value = float(states[quantity][state])
            rows.append(
                {
                    "method": method,
                    "quantity": quantity,
                    "published": value,
                    "simulated_mean": simulated.mean() if len(simulated) else float("nan"),
                    "simulated_min": simulated.min() if len(simulated) else float("nan"),
                    "simulated_max": simulated.max() if len(simulated) else float("nan"),
                    "percentile": 100.0 * np.mean(simulated < value) if len(simulated) else float("nan"),
                    "seeds": len(simulated),
                }
            )
    return pd.DataFrame(rows)


def headline_numbers(
    summary: pd.DataFrame,
    placed: pd.DataFrame,
    planes: pd.DataFrame,
    parameters: pd.DataFrame,
    singular_values: pd.DataFrame,
    null_directions: pd.DataFrame,
) -> dict[str, Any]:
    """Return the numbers of a study of one case that the paper quotes, by method; units are in the names.

    Args:
        summary: As ``summarise_errors`` returns it.
        placed: As ``place_published`` returns it.
        planes: As ``summarise_planes`` returns it.
        parameters: As ``summarise_parameters`` returns it.
        singular_values: singular_values.csv.
        null_directions: null_directions.csv.
    """
    methods: dict[str, Any] = {}
    for method, rows in _groups(summary, "method"):
        first: Any = rows.iloc[0]
        entry: dict[str, Any] = {
            "seeds": int(first["seeds"]),
            "without_calibration": int(first["without_calibration"]),
            "not_converged": int(first["not_converged"]),
        }
        for alignment, group in _groups(rows, "alignment"):
            records: list[dict[str, Any]] = group.to_dict("records")
            entry[str(alignment)] = {row["quantity"]: {k: row[k] for k in STATISTICS} for row in records}
        estimated: Any = parameters[parameters["method"] == method]
        if len(estimated):
            squared = estimated["normalized_rms"].to_numpy(dtype=float) ** 2
            entry["normalized_error_rms"] = float(np.sqrt(squared.mean()))
            entry["within_2_std"] = float(estimated["within_2_std"].mean())
        of_planes: Any = planes[planes["method"] == method]
        if len(of_planes):
            entry["planes"] = {
                "normal_error_max_deg": float(of_planes["normal_error_max_deg"].max()),
                "distance_error_max_mm": float(of_planes["distance_error_max_mm"].max()),
                "within_published": float(of_planes["within_published"].mean()),
            }
        of_placed: Any = placed[placed["method"] == method]
        entry["published"] = {
            row["quantity"]: {"value": row["published"], "percentile": row["percentile"]}
            for row in of_placed.to_dict("records")
        }
        methods[str(method)] = entry
    nonzero: Any = singular_values.loc[~singular_values["null"], "singular_value"]
    return {
        "methods": methods,
        "identifiability": {
            "columns": len(singular_values),
            "zero_singular_values": len(singular_values) - len(nonzero),
            "smallest_nonzero": float(nonzero.min()),
            "held": list(null_directions["held"]),
        },
    }
