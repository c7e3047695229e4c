"""Summaries of the tracked trials.

Rates and errors are given for each kind of sensor and for each level at which the noise was stated in the dataset (``design.STATED``), outcomes for
each cause, verdicts for the sets without a cause, and the sets with a grave fault one by one.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.statistics import wilson
from study.common.provenance import code_version, design_identity
from study.tracked_trials.design import SENSORS, STATED
from study.tracked_trials.run import DRAWN
from study.tracked_trials.score import RATES, cause_outcome, tracked_score

ALL = "all"  # in the columns ``sensor`` and ``stated``: the sets of all levels together
OUTCOMES = ("right", "listed", "unobservable", "missed")  # of a cause, as ``cause_outcome`` returns them


def scored(sets: Any) -> pd.DataFrame:
    """Return the sets with their scores: the columns ``RATES``, ``after_over_before``, and ``causes`` (the number of injected causes)."""
    rows = []
    for row in sets.to_dict("records"):
        causes, found, unobservable = (json.loads(row[key]) for key in ("injected", "found", "unobservable"))
        failed = row["status"] != "diagnosed"
        errors = {when: None if failed else float(row[f"unseen_{when}_mm"]) for when in ("before", "after")}
        score = tracked_score(causes, row["repeatability_rad"] == 0, found, unobservable, errors)
        ratio = np.nan if failed else row["unseen_after_mm"] / row["unseen_before_mm"]
        rows.append({**row, **score, "after_over_before": ratio, "causes": len(causes)})
    return pd.DataFrame(rows)


def rates(scores: Any) -> pd.DataFrame:
    """Return a row for each kind of sensor, stated level and rate: count, share and Wilson's 95 % interval of the share."""
    rows = []
    for key, group in _groups(scores):
        for rate in RATES:
            hits = int(group[rate].sum())
            low, high = wilson(hits, len(group))
            row = {**key, "rate": rate, "sets": len(group), "count": hits, "share": hits / len(group)}
            rows.append(row | {"low": low, "high": high})
    return pd.DataFrame(rows)


def errors(scores: Any) -> pd.DataFrame:
    """Return medians of the RMS errors over unseen poses [mm], and the median and the largest ratio of after to before.

    A row for each kind of sensor and stated level, over the sets that were diagnosed.
    """
    rows = []
    for key, group in _groups(scores[~scores["failed"]]):
        medians = {
            f"{when}_median_mm": float(group[f"unseen_{when}_mm"].median())
            for when in ("before", "found", "after")
        }
        ratio = group["after_over_before"]
        rows.append(
            {**key, "sets": len(group), **medians}
            | {"ratio_median": float(ratio.median()), "ratio_largest": float(ratio.max())}
        )
    return pd.DataFrame(rows)


def by_cause(sets: Any) -> pd.DataFrame:
    """Return for each kind of sensor and cause how often it was injected, and the number of each of ``OUTCOMES``."""
    rows = [
        {
            "sensor": row["sensor"],
            "cause": cause["name"],
            "outcome": cause_outcome(cause, json.loads(row["found"]), json.loads(row["unobservable"])),
        }
        for row in sets.to_dict("records")
        for cause in json.loads(row["injected"])
    ]
    outcomes: Any = pd.DataFrame(rows, columns=["sensor", "cause", "outcome"])
    return pd.DataFrame(
        [
            {"sensor": sensor, "cause": cause, "injected": len(group)}
            | {outcome: int((group["outcome"] == outcome).sum()) for outcome in OUTCOMES}
            for (sensor, cause), group in outcomes.groupby(["sensor", "cause"])
        ],
        columns=["sensor", "cause", "injected", *OUTCOMES],
    )


def nulls(scores: Any) -> pd.DataFrame:
    """Return the number of sets without any cause by kind of sensor, stated level and verdict; ``failed`` if there was no answer."""
    without_cause = scores[scores["causes"] == 0]
    groups = without_cause.fillna({"verdict": "failed"}).groupby(["sensor", "stated", "verdict"], sort=False)
    return groups.size().rename("sets").reset_index()


def faults(scores: Any) -> pd.DataFrame:
    """Return the sets with a wrong name of confidence 0.8 or more, a correction that makes unseen poses worse, or no answer."""
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
    grave = scores[scores["wrong_sure"] | scores["worse"] | scores["failed"]]
    return grave[["wrong_sure", "worse", "failed", *columns]]


def summarise_tracked(
    sets: pd.DataFrame, design: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, pd.DataFrame]]:
    """Return numbers and tables.

    The numbers are the commit, the design with its hash, the counts of ``RATES`` and the processor time. The tables are ``table`` (the rates),
    ``errors``, ``causes``, ``nulls`` and ``faults``.

    Args:
        sets: The results of all sets, a row for each.
        design: Content of the config from which the sets were drawn.
    """
    scores: Any = scored(sets)
    numbers = {
        "code": code_version(),
        "design": design_identity(design),
        "sets": len(scores),
        **{rate: int(scores[rate].sum()) for rate in RATES},
        "processor_s": float(scores["seconds"].sum()),
    }
    return numbers, {
        "table": rates(scores),
        "errors": errors(scores),
        "causes": by_cause(sets),
        "nulls": nulls(scores),
        "faults": faults(scores),
    }


def _groups(scores: Any) -> Iterator[tuple[dict[str, str], Any]]:
    """Yield ``{"sensor": .., "stated": ..}`` and the sets of every kind of sensor and stated level, ``ALL`` among them; empty groups are left out."""
    for sensor in (*SENSORS, ALL):
        for stated in (*STATED, ALL):
            group = scores
            for column, level in (("sensor", sensor), ("stated", stated)):
                group = group if level == ALL else group[group[column] == level]
            if len(group):
                yield {"sensor": sensor, "stated": stated}, group
