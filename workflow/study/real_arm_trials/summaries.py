"""Summaries of the real-arm trials: rates by effect, size and company, errors, and the sets with a grave fault one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.statistics import wilson
from study.common.provenance import code_version, design_identity
from study.real_arm_trials.design import NONE, SIZES
from study.real_arm_trials.score import OF_ALL, OF_EFFECTS, OF_NULLS, RATES, real_arm_score

ALL = "all"  # in the columns that say which sets are counted: the sets of all levels together
ALONE, BESIDE_TWO = "alone", "beside two"
KEYS = ("instrument", "effect", "size", "company")
COUNTED = (
    ("instrument", "effect", "size", "company"),
    ("instrument", "effect", "size"),
    ("instrument", "effect", "company"),
    ("instrument", "effect"),
    ("instrument", "size"),
    ("instrument",),
    ("effect",),
    ("size", "company"),
    ("size",),
    ("company",),
    (),
)
"""Which levels are distinguished in a row of the table; those of the others are counted together."""


def scored(sets: Any) -> pd.DataFrame:
    """Return the sets with their scores: the columns ``RATES``, and ``after_over_before``, the ratio of the errors over unseen poses."""
    rows = [
        {**row, **real_arm_score(row), "after_over_before": row["unseen_after_mm"] / row["unseen_before_mm"]}
        for row in sets.to_dict("records")
    ]
    return pd.DataFrame(rows)


def rates(scores: Any) -> pd.DataFrame:
    """Return a row for each group of sets and rate: count, share and Wilson's 95 % interval of the share.

    Shares of effects are of the sets with an effect, and false alarms of those without.
    """
    rows = []
    for key, group in _groups(scores):
        null = group["effect"] == NONE
        for names, counted in ((OF_EFFECTS, group[~null]), (OF_ALL, group), (OF_NULLS, group[null])):
            for rate in names if len(counted) else ():
                hits = int(counted[rate].sum())
                low, high = wilson(hits, len(counted))
                row = {**key, "rate": rate, "sets": len(counted), "count": hits, "share": hits / len(counted)}
                rows.append(row | {"low": low, "high": high})
    return pd.DataFrame(rows)


def errors(scores: Any) -> pd.DataFrame:
    """Return medians of the RMS errors over unseen poses [mm], and the median and the largest ratio of after to before.

    A row for each group of sets, over those that were diagnosed.
    """
    rows = []
    for key, group in _groups(scores[~scores["failed"]]):
        medians = {
            f"{when}_median_mm": float(group[f"unseen_{when}_mm"].median()) for when in ("before", "after")
        }
        ratio = group["after_over_before"]
        rows.append(
            {**key, "sets": len(group), **medians}
            | {"ratio_median": float(ratio.median()), "ratio_largest": float(ratio.max())}
        )
    return pd.DataFrame(rows)


def faults(scores: Any) -> pd.DataFrame:
    """Return the sets with a wrong name of confidence 0.8 or more, a correction that makes unseen poses worse, a false alarm, or no answer."""
    grave = ["wrong_sure", "worse", "false_alarm", "failed"]
    columns = [
        *KEYS,
        "number",
        "seed",
        "attempt",
        "robot",
        "poses",
        "noise_m",
        "states_noise",
        "repeatability_rad",
    ]
    columns += ["record", "sessions", "injected", "found", "unseen_before_mm", "unseen_after_mm", "reason"]
    return scores[scores[grave].any(axis=1)][[*grave, *columns]]


def summarise_real_arm(
    sets: pd.DataFrame, design: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, pd.DataFrame]]:
    """Return numbers and tables.

    The numbers are the commit, the design with its hash, the numbers of sets with and without an effect, the counts of ``RATES`` and the processor
    time. The tables are ``table`` (the rates), ``errors`` and ``faults``.

    Args:
        sets: The results of all sets, a row for each.
        design: Content of the config from which the sets were drawn.
    """
    scores: Any = scored(sets)
    null = scores["effect"] == NONE
    numbers = {
        "code": code_version(),
        "design": design_identity(design),
        "sets": {"with_an_effect": int((~null).sum()), "without": int(null.sum())},
        **{rate: int(scores[rate].sum()) for rate in RATES},
        "processor_s": float(np.nansum(scores[["simulate_s", "diagnose_s"]].to_numpy(float))),
    }
    return numbers, {"table": rates(scores), "errors": errors(scores), "faults": faults(scores)}


def _groups(scores: Any) -> Iterator[tuple[dict[str, str], Any]]:
    """Yield what ``COUNTED`` says of a group of sets, and its sets, in the order of the design; empty groups are left out."""
    company = np.where(scores["effect"] == NONE, NONE, np.where(scores["company"] == 0, ALONE, BESIDE_TWO))
    texts = scores.assign(company=company)
    ordered = {key: list(dict.fromkeys(texts[key])) for key in KEYS}
    ordered["size"] = [size for size in (*SIZES, NONE) if size in ordered["size"]]
    for told_apart in COUNTED:
        levels = pd.MultiIndex.from_product([ordered[key] if key in told_apart else [ALL] for key in KEYS])
        for level in levels:
            key = dict(zip(KEYS, level, strict=True))
            chosen = np.ones(len(texts), bool)
            for name in told_apart:
                chosen &= (texts[name] == key[name]).to_numpy()
            if chosen.any():
                yield key, texts[chosen]
