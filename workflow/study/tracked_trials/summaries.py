"""Summaries of the tracked trials: rates with intervals by kind of sensor and by what was stated, causes, nulls, errors and faults."""

# pandas is not annotated throughout.
from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from hashlib import sha256
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.statistics import wilson
from study.common.provenance import code_version
from study.tracked_trials.design import SENSORS, STATED
from study.tracked_trials.run import DRAWN
from study.tracked_trials.score import RATES, cause_outcome, tracked_score

ALL = "all"
OUTCOMES = ("right", "listed", "unobservable", "missed")


def scored(sets: Any) -> pd.DataFrame:
    """Return the sets with the columns ``RATES`` and ``after_over_before`` beside them."""
    rows = []
    for row in sets.to_dict("records"):
        causes, found, unobservable = (json.loads(row[key]) for key in ("injected", "found", "unobservable"))
        failed = row["status"] != "diagnosed"
        errors = {w: None if failed else float(row[f"unseen_{w}_mm"]) for w in ("before", "after")}
        score = tracked_score(causes, row["repeatability_rad"] == 0, found, unobservable, errors)
        ratio = np.nan if failed else row["unseen_after_mm"] / row["unseen_before_mm"]
        rows.append({**row, **score, "after_over_before": ratio, "causes": len(causes)})
    return pd.DataFrame(rows)


def table(judged: Any) -> pd.DataFrame:
    """Return a row for each kind of sensor, level stated and rate: count, share and its 95 % interval (Wilson's)."""
    rows = []
    for place, group in _groups(judged):
        for rate in RATES:
            hits = int(group[rate].sum())
            low, high = wilson(hits, len(group))
            row = {**place, "rate": rate, "sets": len(group), "count": hits, "share": hits / len(group)}
            rows.append(row | {"low": low, "high": high})
    return pd.DataFrame(rows)


def errors(judged: Any) -> pd.DataFrame:
    """Return medians of the rms errors over unseen poses [mm], and quantiles of after over before, of the sets with an answer."""
    rows = []
    for place, group in _groups(judged[~judged["failed"]]):
        medians = {
            f"{when}_median_mm": float(group[f"unseen_{when}_mm"].median())
            for when in ("before", "found", "after")
        }
        ratio = group["after_over_before"]
        rows.append(
            {**place, "sets": len(group), **medians}
            | {"ratio_median": float(ratio.median()), "ratio_largest": float(ratio.max())}
        )
    return pd.DataFrame(rows)


def by_cause(sets: Any) -> pd.DataFrame:
    """Return how often each cause is right, listed, unobservable and missed, by kind of sensor."""
    rows = [
        {
            "sensor": row["sensor"],
            "cause": cause["name"],
            "outcome": cause_outcome(cause, json.loads(row["found"]), json.loads(row["unobservable"])),
        }
        for row in sets.to_dict("records")
        for cause in json.loads(row["injected"])
    ]
    known: Any = pd.DataFrame(rows, columns=["sensor", "cause", "outcome"])
    return pd.DataFrame(
        [
            {"sensor": sensor, "cause": cause, "injected": len(group)}
            | {outcome: int((group["outcome"] == outcome).sum()) for outcome in OUTCOMES}
            for (sensor, cause), group in known.groupby(["sensor", "cause"])
        ],
        columns=["sensor", "cause", "injected", *OUTCOMES],
    )


def nulls(judged: Any) -> pd.DataFrame:
    """Return the verdicts of the sets without any cause."""
    none = judged[judged["causes"] == 0]
    counted = none.fillna({"verdict": "failed"}).groupby(["sensor", "stated", "verdict"], sort=False)
    return counted.size().rename("sets").reset_index()


def faults(judged: Any) -> pd.DataFrame:
    """Return the sets with a wrong name of 0.8 or more, a correction that makes unseen poses worse, or no answer."""
    columns = [
        *DRAWN,
        "poses",
        "injected",
        "verdict",
        "found",
        "unseen_before_mm",
        "unseen_after_mm",
        "reason",
    ]
    grave = judged[judged["wrong_sure"] | judged["worse"] | judged["failed"]]
    return grave[["wrong_sure", "worse", "failed", *columns]]


def summarise_tracked(
    sets: pd.DataFrame, design: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, pd.DataFrame]]:
    """Return numbers (what made the tables, how long it took) and the tables ``table, errors, causes, nulls, faults``.

    Args:
        sets: A row a set. design: Content of the config that they were drawn from.
    """
    judged: Any = scored(sets)
    numbers = {
        "code": code_version(),
        "design": {
            "seed": design["seed"],
            "sealed_after": design.get("sealed_after"),
            "sha256": sha256(json.dumps(design, sort_keys=True).encode()).hexdigest(),
        },
        "sets": len(judged),
        **{rate: int(judged[rate].sum()) for rate in RATES},
        "processor_s": float(judged["seconds"].sum()),
    }
    return numbers, {
        "table": table(judged),
        "errors": errors(judged),
        "causes": by_cause(sets),
        "nulls": nulls(judged),
        "faults": faults(judged),
    }


def _groups(judged: Any) -> Iterator[tuple[dict[str, str], Any]]:
    """Yield the sets of each kind of sensor and level stated, and of all of them, where there are any."""
    for sensor in (*SENSORS, ALL):
        for stated in (*STATED, ALL):
            group = judged
            for column, level in (("sensor", sensor), ("stated", stated)):
                group = group if level == ALL else group[group[column] == level]
            if len(group):
                yield {"sensor": sensor, "stated": stated}, group
