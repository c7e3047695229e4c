"""Compute, from the committed tables, the numbers of the blind trials that the paper quotes in addition to ``numbers.json``.

Rates count every effect, also a range gain that leaves no residual; their intervals are found by drawing whole scenes. Errors after a correction are
given for each effect with the 95 % quantile. Unknown causes are grouped by whether the estimator has a flexible term of the same formula.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.registry import known
from study.blind_trials.numbers import UNOBSERVABLE
from study.blind_trials.score import NOISES, SLACK_POSES
from study.blind_trials.statistics import LEVEL, clustered_interval, wilson
from study.blind_trials.stratified_summaries import QUANTILES
from study.blind_trials.summaries import NATURAL
from study.common.effect_words import case_words

SAME_FORMULA = (
    "angle_bump",
    "angle_step",
    "angle_product",
    "encoder_drift",
    "late_jump",
    "sensor_oscillation",
)
"""Unknown causes for which the estimator has a flexible term of the same formula (``effects/flexible``)."""
IMITATED = ("worn_teeth", "belt")
"""Unknown causes that a flexible term imitates: a plateau imitates worn teeth, waves imitate a belt."""
JITTERY = "null-jittery"
"""The sets without a systematic effect whose joints jitter."""
NAMED = ("right", "listed", "elsewhere", "wrong")
"""Outcomes in which a name was given."""


def reported_trials(tables: Mapping[str, pd.DataFrame]) -> dict[str, Any]:
    """Return the numbers that the paper quotes in addition to ``numbers.json``.

    Args:
        tables: ``{name: table}`` of the summaries named in ``study.paper.reported.TABLES``.
    """
    errors: Any = tables["errors"]
    return {
        "interval": LEVEL,
        "slack_poses": SLACK_POSES,
        "natural": _natural(tables["by_scene"], tables["power"]),
        "smaller": _smaller(tables["power"]),
        "unknown": _unknown(tables["unknown"]),
        "after_over_control": _after(errors[errors["size"] == NATURAL]),
        "not_injected": _not_injected(tables["power"]),
        "nulls": _nulls(tables["nulls"]),
    }


def _nulls(nulls: Any) -> dict[str, Any]:
    """Return how many sets without a systematic effect have an answer: those whose joints jitter, and the others."""
    kinds = nulls[nulls["case"] != "all"]
    jitter = kinds["case"] == JITTERY
    found = {}
    for name, part in (("jittery", kinds[jitter]), ("others", kinds[~jitter])):
        sets, count = int(part["sets"].sum()), int(part["count"].sum())
        found[name] = {"sets": sets, "count": count, "high": wilson(count, sets)[1]}
    return found


def _not_injected(power: Any) -> list[str]:
    """Return the effects of the catalogue that were not injected into any set with one effect, in words."""
    injected = {case.split("-")[0] for case in power["case"]}
    names = {*known(), *NOISES} - {Unattributed.name}
    return sorted(map(case_words, names - injected))


def _natural(by_scene: Any, power: Any) -> dict[str, Any]:
    """Return the rates of right names at the natural size, for all effects, and for those that leave a residual and those that leave none."""
    scene = by_scene["workcell"] + " " + by_scene["seed"].astype(str)
    observable = ~by_scene["case"].isin(UNOBSERVABLE)
    not_right = by_scene[observable & (by_scene["right"] == 0)]
    rows = power[power["size"] == NATURAL]
    return {
        "scenes": int(scene.nunique()),
        "workcells": int(by_scene["workcell"].nunique()),
        "all": _share(by_scene["right"], scene, by_scene["workcell"]),
        "observable": _share(
            by_scene["right"][observable], scene[observable], by_scene["workcell"][observable]
        )
        | {"not_right": len(not_right), "not_right_workcells": int(not_right["workcell"].nunique())},
        "unobservable": {
            "sets": int((~observable).sum()),
            "named": int(by_scene["right"][~observable].sum()),
            "workcells_named": int(by_scene[~observable & (by_scene["right"] == 1)]["workcell"].nunique()),
        },
        "right_with_more": int(rows["with_more"].sum()),
    }


def _share(right: Any, scene: Any, workcell: Any) -> dict[str, Any]:
    """Return the share of ones in ``right``, with two intervals of it: by drawing whole scenes, and by drawing whole workcells."""
    hits = right.to_numpy(dtype=float)
    by_scene, by_workcell = (
        clustered_interval(hits, scene.tolist()),
        clustered_interval(hits, workcell.tolist()),
    )
    return {
        "sets": len(hits),
        "count": int(hits.sum()),
        "share": float(hits.mean()),
        **dict(zip(("low", "high"), by_scene, strict=True)),
        "by_workcell": dict(zip(("low", "high"), by_workcell, strict=True)),
    }


def _smaller(power: Any) -> dict[str, Any]:
    """Return counts and shares of the answers about effects smaller than the natural size."""
    rows = power[power["size"] < NATURAL]
    count = {name: int(rows[name].sum()) for name in (*NAMED, "missed", "unattributed", "unobservable")}
    sets, named = int(rows["right_sets"].sum()), sum(count[name] for name in NAMED)
    false = count["elsewhere"] + count["wrong"]
    return {
        "sets": sets,
        **count,
        "named": named,
        "right_share": count["right"] / sets,
        "missed_share": count["missed"] / sets,
        "wrong_or_misplaced": false,
        "wrong_or_misplaced_share": false / named if named else 0.0,
    }


def _unknown(unknown: Any) -> dict[str, Any]:
    """Return how many unknown causes are reported as unattributed, by whether the estimator has their formula, and by size."""
    kind = unknown["case"].str.removeprefix("unknown-")
    groups = {
        "same_formula": kind.isin(SAME_FORMULA),
        "imitated": kind.isin(IMITATED),
        "other": ~kind.isin((*SAME_FORMULA, *IMITATED)),
    }
    sizes = {"natural": unknown["size"] == NATURAL, "smaller": unknown["size"] < NATURAL}
    return {
        group: {"kinds": int(kind[inside].nunique())}
        | {
            size: {
                "sets": int(unknown["unattributed_sets"][inside & these].sum()),
                "unattributed": int(unknown["unattributed_count"][inside & these].sum()),
            }
            for size, these in sizes.items()
        }
        for group, inside in groups.items()
    } | {"smaller_size": float(unknown["size"].min())}


def _after(errors: Any) -> dict[str, Any]:
    """Return the ratio of the error after the correction to that of the matched control, by effect, over the sets named right.

    For each effect these are the median and the 95 % quantile; effects and unknown causes with the largest medians are listed first.
    """
    known = errors[(errors["sets"] > 0) & errors["after_over_control"].notna()]
    known = known[~known["case"].str.startswith(("null", "pairs"))]
    named = known[~known["case"].str.startswith("unknown")].sort_values("after_over_control", ascending=False)
    unknown = known[known["case"].str.startswith("unknown")].sort_values(
        "after_over_control", ascending=False
    )
    return {
        "worst": [_row(row) for row in named.head(8).to_dict("records")],
        "worst_unknown": [_row(row) for row in unknown.head(3).to_dict("records")],
        "cases": {row["case"]: _row(row) for row in known.to_dict("records")},
        "above_1_2": int((named["after_over_control"] > 1.2).sum()),
        "named_cases": len(named),
    }


def _row(row: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the entry of one effect: its name in words, its kind, and its ratios of errors."""
    case = str(row["case"])
    words = case_words(case.removeprefix("unknown-"))
    kind = "random" if case in NOISES else "systematic"
    return {
        "case": words,
        "kind": kind,
        "sets": int(row["sets"]),
        "median": float(row["after_over_control"]),
        "p95": float(row["after_over_control_p95"]),
        "before_over_after": float(row["before_over_after"]),
    }


STRATIFIED_RATES = (
    "clean",
    "missed",
    "wrong",
    "wrong_sure",
    "wrong_noise",
    "fair",
    "worse",
    "much_worse",
)  # that the paper reports


def reported_stratified(table: pd.DataFrame) -> dict[str, Any]:
    """Return the rates of the stratified trials for each row of the table and for all sets, with Wilson's intervals (each set is a scene).

    Args:
        table: The table of the summaries, with columns ``row, rate, sets, count`` and the last row ``all``; or the record of an earlier run, with
            counts in the columns ``row, sets, clean, missed, worse, much_worse``; an empty cell means that the count was not recorded.
    """
    columns = ("sets", *STRATIFIED_RATES)
    if "rate" in table:
        counts: Any = table.pivot(index="row", columns="rate", values="count")
        sets = table.drop_duplicates("row").set_index("row")["sets"]
        table = counts.assign(sets=sets).loc[sets.index].reset_index()
        alone: Any = table[table["row"] != "all"]
        table = alone
    rows = [_rates(str(row["row"]), row) for row in table.to_dict("records")]
    together = {name: table[name].sum(skipna=False) for name in columns if name in table}
    return {"rows": rows, "all": _rates("all", together)}


STRATIFIED_RATIOS = ("after_over_floor", "after_over_told", "told_over_floor")  # that the paper reports


def with_ratios(reported: Mapping[str, Any], ratios: pd.DataFrame) -> dict[str, Any]:
    """Return what ``reported_stratified`` returns, with quantiles of the ratios ``STRATIFIED_RATIOS`` of errors added.

    A row has no entry for a ratio that is defined in none of its sets, as where every cause is without a name.

    Args:
        reported: What ``reported_stratified`` returns: ``rows`` and ``all``.
        ratios: The table of the summaries with columns ``row, ratio, quantile, value``, and perhaps ``sets``.
    """

    def with_quantiles(rates: Mapping[str, Any]) -> dict[str, Any]:
        row: Any = ratios[ratios["row"] == rates["row"]]
        found = dict(rates)
        for ratio in STRATIFIED_RATIOS:
            some = row[row["ratio"] == ratio].set_index("quantile")
            if len(some):
                values = [float(some.loc[quantile, "value"]) for quantile in QUANTILES]
                found[ratio] = dict(zip(("median", "p95", "greatest"), values, strict=True))
                if "sets" in some:
                    found[ratio]["sets"] = int(some["sets"].iloc[0])
        return found

    return {"rows": [with_quantiles(row) for row in reported["rows"]], "all": with_quantiles(reported["all"])}


def _rates(name: str, row: Mapping[Any, Any]) -> dict[str, Any]:
    """Return count, share and Wilson's interval of every rate of one row; None for a count that was not recorded."""
    sets = int(row["sets"])
    rates: dict[str, Any] = {"row": name, "sets": sets}
    for key in STRATIFIED_RATES:
        if pd.isna(row.get(key, np.nan)):
            rates[key] = {"count": None, "share": None}
            continue
        count = int(row[key])
        low, high = wilson(count, sets)
        rates[key] = {"count": count, "share": count / sets, "low": low, "high": high}
    return rates
