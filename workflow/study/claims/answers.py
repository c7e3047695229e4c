"""What the tables of a run say about a claim of the original paper, for each way to calibrate.

Values are medians over the seeds with their band, the 5 and 95 % quantiles. Errors are raw (the base is not aligned), and walls are upright.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import INITIAL, METHODS, PROPOSED

WALLS = "upright"


@dataclass(frozen=True)
class Results:
    """The tables that answer claims; one that a run lacks is None or missing.

    Attributes:
        headline: summary.csv of the main study.
        planes: planes.csv.
        singular_values: singular_values.csv.
        arms: other_arms.csv.
        workspace: workspace.csv, the errors of the proposed method by place, with the column ``seeds``.
        sequential: summary.csv of the comparison with sequential calibration.
        sweeps: ``{name of a sweep: its summary.csv}``.
        seconds: ``{way to calibrate: wall time of a whole calibration [s]}``.
    """

    headline: Any = None
    planes: Any = None
    singular_values: Any = None
    arms: Any = None
    workspace: Any = None
    sequential: Any = None
    sweeps: Mapping[str, Any] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """What one way to calibrate found for a claim; numbers are in the claim's unit, and NaN if they do not apply.

    Attributes:
        way: Way to calibrate; empty if the claim does not depend on it.
        value: Median over the seeds, or the share, ratio or count that the rule judges.
        low: Lower end of the band, the 5 % quantile over the seeds; for ``at_once``, the least share over all cases.
        high: Upper end of the band, the 95 % quantile.
        least: Smallest value of a seed.
        most: Largest value of a seed.
        seeds: Number of seeds.
        succeeded: Share of the fits that succeeded.
    """

    way: str
    value: float
    low: float = np.nan
    high: float = np.nan
    least: float = np.nan
    most: float = np.nan
    seeds: int = 0
    succeeded: float = 1.0


def answers_of(claim: Mapping[str, Any], results: Results) -> list[Found]:
    """Return what each way to calibrate found for a claim; an empty list if the run has no such table or point."""
    source = str(claim["source"])
    if source == "headline" and results.headline is not None:
        return _of_headline(claim, results.headline)
    if source == "planes" and results.planes is not None:
        return _of_planes(claim, results.planes)
    if source == "singular_values" and results.singular_values is not None:
        null = results.singular_values["null"]
        return [Found("", float(null.sum()) if claim["quantity"] == "zero" else float(len(null)), seeds=1)]
    if source == "arms" and results.arms is not None:
        return [Found("", float(results.arms["same_set"].mean()), seeds=1)]
    if source == "workspace" and results.workspace is not None:
        return _of_workspace(claim, results.workspace)
    if source == "sequential" and results.sequential is not None:
        return _of_sequential(claim, results.sequential)
    if source == "benchmark":
        return [Found(way, seconds) for way, seconds in results.seconds.items()]
    name = source.removeprefix("sweep:")
    return _of_sweep(claim, results.sweeps[name]) if name in results.sweeps else []


def _of_headline(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    rows = summary[(summary["alignment"] == "raw") & (summary["quantity"] == claim["quantity"])]
    rows = rows[(rows["method"] == INITIAL) == (claim["rule"] == "draw")]
    return [
        _over_seeds("" if row["method"] == INITIAL else row["method"], row) for row in rows.to_dict("records")
    ]


def _over_seeds(way: str, row: Mapping[str, Any]) -> Found:
    """Return what a row of a summary states for a claim: median, band, range, seeds and the share of fits that succeeded."""
    failed = row.get("not_converged", row.get("failed", 0) + row.get("lost", 0))
    seeds, succeeded = int(row["seeds"]), 1 - failed / row["seeds"]
    return Found(way, row["median"], row["p05"], row["p95"], row["min"], row["max"], seeds, succeeded)


def _of_planes(claim: Mapping[str, Any], planes: Any) -> list[Found]:
    """Return the share of seeds in which the error of every plane lies within the claimed limit; a seed without a calibration counts as outside."""
    rows = planes[planes["method"] != INITIAL]
    seeds = planes["seed"].unique()
    inside = rows[claim["quantity"]].abs() <= float(claim["published"])
    found = []
    for way, of_way in inside.groupby(rows["method"], sort=False):
        whole = of_way.groupby(rows["seed"]).all().reindex(seeds, fill_value=False)
        found.append(Found(str(way), float(whole.mean()), seeds=len(whole)))
    return found


def _of_workspace(claim: Mapping[str, Any], workspace: Any) -> list[Found]:
    """Return the share of the places of the scanner, as seen from the side, whose root mean square error is at most the claimed number."""
    places = workspace[workspace["view"] == "side"]
    if places.empty:
        return []
    errors = places[claim["quantity"]]
    share = float((errors <= float(claim["published"])).mean())
    least, most = float(errors.min()), float(errors.max())
    return [Found(PROPOSED, share, least=least, most=most, seeds=int(places["seeds"].iloc[0]))]


def _of_sweep(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    rows = summary[
        (summary["walls"] == WALLS)
        & (summary["alignment"] == "raw")
        & (summary["quantity"] == claim["quantity"])
        & summary["method"].isin(METHODS)
    ]
    found = []
    for way, of_way in rows.groupby("method", sort=False):
        here = _at(of_way, claim["value"])
        there = None if pd.isna(claim["of"]) else _at(of_way, claim["of"])
        if here is None or (there is None and not pd.isna(claim["of"])):
            continue
        bad = (here["failed"] + here["lost"]) / here["seeds"]
        if claim["rule"] == "fails":
            enough = 1.0 if there is None else 1 - (there["failed"] + there["lost"]) / there["seeds"]
            found.append(Found(str(way), bad, seeds=int(here["seeds"]), succeeded=enough))
        elif claim["rule"] == "suffices":
            found.append(Found(str(way), 1 - bad, seeds=int(here["seeds"])))
        elif there is not None:
            ratio = here["median"] / there["median"]
            found.append(Found(str(way), ratio, seeds=int(here["seeds"]), succeeded=1 - bad))
        else:
            found.append(_over_seeds(str(way), here))
    return found


def _at(rows: Any, value: Any) -> dict[str, Any] | None:
    """Return the row at a value on the axis of a sweep; None without one."""
    near = rows[np.isclose(rows["value"], float(value), rtol=1e-9, atol=0)]
    return near.iloc[0].to_dict() if len(near) else None


def _of_sequential(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    """Return for each order the share of seeds in which one pass is worse than fitting at once: in the first case, and the least as ``low``."""
    rows = summary[
        (summary["stage"] == "one_pass")
        & (summary["alignment"] == "raw")
        & (summary["quantity"] == claim["quantity"])
    ]
    found = []
    for way, of_way in rows.groupby("way", sort=False):
        shares = of_way["worse_than_at_once"]
        found.append(
            Found(
                str(way), float(shares.iloc[0]), low=float(shares.min()), seeds=int(of_way["seeds"].iloc[0])
            )
        )
    return found
