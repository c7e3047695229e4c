"""Compute the numbers of the sweeps that the paper quotes.

These are slopes, ratios to the Cramér-Rao bound, how far initial guesses may be off, how fits failed, and how many published values lie within the
simulated bands. They use raw errors (the base is not aligned) of the fits that converged. A fit has *succeeded* if it converged and its mean position
error is at most ``LOST_MM``. If a run lacks a sweep or a value on its axis, the numbers that need it are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import BOUND, CONVERGED, EFFICIENT, INITIAL
from study.common.statistics import QUANTITIES, summary_statistics
from study.sweeps.summary import LOST_MM

MAIN = QUANTITIES[0]
"""The quantity of ratios and slopes where no other is named: the mean position error."""
NEAR_BOUND = 0.10
"""Relative distance from the bound within which an estimate counts as efficient."""
SWEEPS_OF_THE_START = ("plane_tilt", "plane_offset", "initial_model")
"""Sweeps of the error of the initial guess, of which the largest error with which every fit succeeds is computed."""
ENOUGH = {"poses": (60.0, 120.0), "points": (20.0, 100.0)}
"""``{sweep: (few, many)}``: the original paper claims that few are enough; computed is the error at few divided by that at many."""
FEWEST = 3
"""How many of the smallest numbers of poses are looked at: those around which the equations, two for each pose, become as many as the unknowns."""


def sweep_numbers(
    errors: Mapping[str, pd.DataFrame], placed: Mapping[str, pd.DataFrame], labels: Mapping[str, str]
) -> dict[str, Any]:
    """Return the numbers of all sweeps; units are in the names, and values on an axis have the unit of its label.

    Args:
        errors: ``{sweep: its errors.csv}``.
        placed: ``{sweep: its published_among_simulated.csv}``, where each published value lies among the simulated ones.
        labels: ``{sweep: label of its axis}``.
    """
    raw = {name: _raw_with_success(table) for name, table in errors.items()}
    return {
        "lost_beyond_mm": LOST_MM,
        "sweeps": {
            name: {"label": labels[name], "walls": _by_walls(table, _cases)} for name, table in raw.items()
        },
        "noise_slope": _by_walls(raw["noise"], _by_method(_slope)) if "noise" in raw else {},
        "near_bound": _near_bound(raw),
        "edges": {
            name: _by_walls(raw[name], _by_method(_success)) for name in SWEEPS_OF_THE_START if name in raw
        },
        "enough": {
            name: {"value": few, "of": many, "walls": _by_walls(raw[name], _by_method(_ratio(few, many)))}
            for name, (few, many) in ENOUGH.items()
            if name in raw
        },
        "fewest_poses": _fewest(placed["poses"]) if "poses" in placed else {},
        "failures": _failures(raw),
        "published_inside": _inside(placed),
    }


def join_placed(placed: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the tables of the sweeps as one, with the column ``sweep`` first."""
    parts = [table.assign(sweep=name) for name, table in placed.items() if len(table)]
    empty = pd.DataFrame(columns=["sweep", *next(iter(placed.values())).columns])
    whole: Any = pd.concat(parts, ignore_index=True) if parts else empty
    return whole[["sweep", *(name for name in whole.columns if name != "sweep")]]


def _raw_with_success(table: Any) -> Any:
    """Return the rows of raw errors, with the columns ``converged`` and ``succeeded`` (bool)."""
    raw = table[table["alignment"] == "raw"]
    converged = raw["status"] == CONVERGED
    return raw.assign(converged=converged, succeeded=converged & (raw[MAIN] <= LOST_MM))


def _by_walls(table: Any, ask: Any) -> dict[str, Any]:
    """Return ``{kind of walls: ask(its rows)}``; the kinds are upright walls and walls that lean."""
    return {str(walls): ask(rows) for walls, rows in table.groupby("walls", sort=False)}


def _by_method(ask: Any) -> Any:
    """Return a function of a table that returns ``{method: ask(its rows)}``; a method for which that is None is left out."""

    def asked(table: Any) -> dict[str, Any]:
        answers = {method: ask(rows) for method, rows in _methods(table)}
        return {method: answer for method, answer in answers.items() if answer is not None}

    return asked


def _methods(table: Any) -> list[tuple[str, Any]]:
    """Return the methods of a table with their rows, without the model before calibration, the bound and the efficient estimate."""
    no_methods = (INITIAL, BOUND, EFFICIENT)
    return [(str(m), rows) for m, rows in table.groupby("method", sort=False) if m not in no_methods]


def _cases(table: Any) -> dict[str, Any]:
    """Return ``{case: {value, bound, methods}}``, with counts of how fits ended, errors and ratios to the bound of each method."""
    cases: dict[str, Any] = {}
    for case, rows in table.groupby("case", sort=False):
        bound = rows[rows["method"] == BOUND]
        cases[str(case)] = {
            "value": float(rows["value"].iloc[0]),
            "bound": {q: float(bound[q].mean()) for q in QUANTITIES} if len(bound) else None,
            "methods": {m: _ends(own) | _errors(own) | _ratios(own, rows) for m, own in _methods(rows)},
        }
    return cases


def _ends(rows: Any) -> dict[str, int]:
    """Return how many fits ended in which way.

    ``failed`` counts every fit that did not converge. Among these, ``refused`` ones have no model, ``raised`` ones met a NaN, and ``capped`` ones
    reached the largest number of evaluations. ``lost`` ones converged farther than ``LOST_MM`` from the truth.
    """
    status = rows["status"]
    return {
        "seeds": len(rows),
        "succeeded": int(rows["succeeded"].sum()),
        "lost": int((rows["converged"] & ~rows["succeeded"]).sum()),
        "failed": int((~rows["converged"]).sum()),
        "refused": int(rows[MAIN].isna().sum()),
        "raised": int((status == "raised").sum()),
        "capped": int((status == "capped").sum()),
    }


def _errors(rows: Any) -> dict[str, Any]:
    """Return statistics over the seeds whose fit converged, for each quantity."""
    ended = rows[rows["converged"]]
    names = ("mean", "median", "p05", "p95", "min", "max")
    over = {q: summary_statistics(ended[q].to_numpy(dtype=float)) for q in QUANTITIES}
    return {q: {name: values[name] for name in names} for q, values in over.items()}


def _ratios(rows: Any, case: Any) -> dict[str, Any]:
    """Return the ratio of the mean error to the bound, with its standard error, and that to the efficient estimate from the same noise.

    Args:
        rows: Rows of one method in one case.
        case: All rows of that case, among them those of the bound and of the efficient estimate.
    """
    of_method = rows[rows["converged"]].set_index("seed")[MAIN]
    bound = case[case["method"] == BOUND].set_index("seed")[MAIN]
    efficient = case[case["method"] == EFFICIENT].set_index("seed")[MAIN]
    if not len(of_method) or not len(bound):
        return {"over_bound": None, "over_efficient": None}
    expected = float(bound[of_method.index].mean())
    std = float(of_method.std() / np.sqrt(len(of_method)) / expected) if len(of_method) > 1 else float("nan")
    return {
        "over_bound": {"ratio": float(of_method.mean()) / expected, "std": std},
        "over_efficient": float(of_method.mean() / efficient[of_method.index].mean()),
    }


def _slope(rows: Any) -> dict[str, float] | None:
    """Return the slope of log error against log noise, over all noises above zero, and the least and greatest ratio of error to noise."""
    mean = rows[rows["converged"] & (rows["value"] > 0)].groupby("value")[MAIN].mean()
    if len(mean) < 2:
        return None
    noise, error = mean.index.to_numpy(dtype=float), mean.to_numpy(dtype=float)
    gain = error / noise
    return {
        "slope": float(np.polyfit(np.log(noise), np.log(error), 1)[0]),
        "from_mm": float(noise.min()),
        "to_mm": float(noise.max()),
        "error_at_smallest_mm": float(error[0]),
        "error_over_noise_min": float(gain.min()),
        "error_over_noise_max": float(gain.max()),
    }


def _near_bound(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return for each method how many cases of all sweeps and walls lie within 10 % of the bound, and of the efficient estimate."""
    found: dict[str, list[dict[str, Any]]] = {}
    for name, table in raw.items():
        for (walls, case), rows in table.groupby(["walls", "case"], sort=False):
            for method, own in _methods(rows):
                over = _ratios(own, rows)
                if over["over_bound"] is not None:
                    all_converged = bool(own["converged"].all())
                    point = {"point": f"{name}/{case}/{walls}", "all_converged": all_converged}
                    found.setdefault(method, []).append(point | over)
    answer: dict[str, Any] = {}
    for method, points in found.items():
        ratio = np.array([p["over_bound"]["ratio"] for p in points])
        std = np.array([p["over_bound"]["std"] for p in points])
        paired = np.array([p["over_efficient"] for p in points])
        worst = int(np.argmax(np.abs(np.log(paired))))
        answer[method] = {
            "points": len(points),
            "all_converged": sum(p["all_converged"] for p in points),
            "within_10_percent_of_efficient": int((np.abs(paired - 1) <= NEAR_BOUND).sum()),
            "within_10_percent_of_bound": int((np.abs(ratio - 1) <= NEAR_BOUND).sum()),
            "within_10_percent_or_2_std_of_bound": int(
                (np.abs(ratio - 1) <= np.maximum(NEAR_BOUND, 2 * std)).sum()
            ),
            "over_bound_median": float(np.median(ratio)),
            "over_bound_min": float(ratio.min()),
            "over_bound_max": float(ratio.max()),
            "over_bound_std_median": float(np.median(std)),
            "over_efficient_median": float(np.median(paired)),
            "over_efficient_worst": float(paired[worst]),
            "over_efficient_worst_at": points[worst]["point"],
        }
    return answer


def _success(rows: Any) -> dict[str, Any]:
    """Return up to which value on the axis every seed succeeds, the first value with a failure, and the number of successes at each value."""
    by_value = rows.groupby("value", sort=True)
    values = [float(value) for value, _ in by_value]
    succeeded = [int(own["succeeded"].sum()) for _, own in by_value]
    seeds = [len(own) for _, own in by_value]
    good = [s == n for s, n in zip(succeeded, seeds, strict=True)]
    first = good.index(False) if False in good else len(good)
    none = [value for value, s in zip(values, succeeded, strict=True) if s == 0]
    return {
        "all_succeed_up_to": values[first - 1] if first else None,
        "first_failure_at": values[first] if first < len(values) else None,
        "none_succeeds_from": min(none, default=None),
        "succeeded": dict(zip(map(_plain, values), succeeded, strict=True)),
        "seeds": max(seeds),
    }


def _ratio(few: float, many: float) -> Any:
    """Return a function of rows: each quantity's mean at the value ``few`` divided by its mean at ``many``; None if either is missing."""

    def ask(rows: Any) -> dict[str, float] | None:
        ended = rows[rows["converged"]]
        at = [ended[ended["value"] == value] for value in (few, many)]
        if not all(len(one) for one in at):
            return None
        return {q: float(at[0][q].mean() / at[1][q].mean()) for q in QUANTITIES}

    return ask


def _fewest(placed: Any) -> dict[str, Any]:
    """Return where the published mean position error lies among the simulated fits that converged, for the ``FEWEST`` smallest numbers of poses."""
    names = (
        "simulated_min",
        "simulated_median",
        "simulated_max",
        "percentile",
        "seeds",
        "inside_band",
        "inside_range",
    )
    answer: dict[str, Any] = {}
    fewest = sorted(placed["value"].unique())[:FEWEST]
    rows = placed[(placed["quantity"] == MAIN) & placed["value"].isin(fewest)]
    for record in rows.to_dict("records"):
        entry = answer.setdefault(_plain(record["value"]), {"published_mm": record["published"], "walls": {}})
        of_walls = entry["walls"].setdefault(record["walls"], {})
        of_walls[record["method"]] = {name: record[name] for name in names}
    return answer


def _failures(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return for each kind of walls and method how the fits of all sweeps ended."""
    whole = pd.concat(list(raw.values()), ignore_index=True)
    return _by_walls(whole, _by_method(_ends))


def _inside(placed: Mapping[str, pd.DataFrame]) -> dict[str, Any]:
    """Return how many published values lie inside the simulated bands and ranges, by walls and method, for all sweeps and for each."""
    whole: Any = join_placed(placed)
    points = whole[["sweep", "value"]].drop_duplicates()
    values = whole[["sweep", "value", "quantity"]].drop_duplicates()

    def count(rows: Any) -> dict[str, int]:
        counts = {name: int(rows[name].sum()) for name in ("inside_band", "inside_range")}
        below = (rows["published"] < rows["simulated_p05"]).sum()
        above = (rows["published"] > rows["simulated_p95"]).sum()
        return {"values": len(rows)} | counts | {"below_band": int(below), "above_band": int(above)}

    answer: dict[str, Any] = {"points": len(points), "values": len(values), "walls": {}}
    for (walls, method), rows in whole.groupby(["walls", "method"], sort=False):
        by_sweep = {str(name): count(own) for name, own in rows.groupby("sweep", sort=False)}
        answer["walls"].setdefault(str(walls), {})[str(method)] = count(rows) | {"sweeps": by_sweep}
    return answer


def _plain(value: float) -> str:
    return f"{value:g}"
