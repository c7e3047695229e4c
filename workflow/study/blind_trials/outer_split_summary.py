"""Summarise stratified trials that are diagnosed without and with the outer split: rates, the errors that are stated, and names that are refused."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.score import UNATTRIBUTED
from study.blind_trials.statistics import wilson
from study.blind_trials.stratified_score import acceptable, listed
from study.blind_trials.stratified_summaries import scored, truth_in

RATES = ("clean", "missed", "wrong", "wrong_sure", "unattributed", "worse", "much_worse", "failed")
QUANTILES = (0.05, 0.5, 0.95)
ERRORS = {
    "held_out": ("held_out_stated_mm", "held_out_true_mm"),
    "unseen": ("unseen_stated_mm", "unseen_true_mm"),
}
"""``{error: (column as stated, column of the true one)}``: of the diagnosis without the split, and of that with it."""
TENTH_LARGER = 1.1
HALF = 0.5  # of the runs of the split: a name that fewer choose is not confirmed


def with_answers_of_split(sets: pd.DataFrame) -> pd.DataFrame:
    """Return the sets with the answers of the diagnosis with the split in place of those without.

    Args:
        sets: The rows of all sets, with the columns ``SPLIT_COLUMNS`` of ``outer_split``.
    """
    columns: Any = sets
    return columns.assign(
        found=columns["found_split"],
        status=columns["status_split"].where(columns["status"] != "not_simulated", "not_simulated"),
        position_after_mm=columns["position_after_split_mm"],
    )


def split_rates(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each kind of set, rate and diagnosis (``split`` 0 or 1): count, share and Wilson's interval. Arguments as above."""
    rows = []
    both: Any = {0: scored(sets), 1: scored(with_answers_of_split(sets))}
    for kind in [*dict.fromkeys(both[0]["row"]), "all"]:
        for rate in RATES:
            for split, judged in both.items():
                group = judged if kind == "all" else judged[judged["row"] == kind]
                hits, n = int(group[rate].sum()), len(group)
                low, high = wilson(hits, n)
                rows.append(
                    {"row": kind, "rate": rate, "split": split, "sets": n, "count": hits}
                    | {"share": hits / n, "low": low, "high": high}
                )
    return pd.DataFrame(rows)


def split_numbers(sets: pd.DataFrame) -> dict[str, Any]:
    """Return how many sets were diagnosed with the split, how its errors agree with the true ones, and what it says of wrong names.

    Returns:
        ``sets``; ``held_out`` and ``unseen``: in how many ``sets`` an error is stated, quantiles of the true over the stated one, and in how many the
        true error is no larger (``covered``) and no more than a tenth larger; ``wrong_names`` and ``right_names``: how many ``names`` the diagnosis
        with the split found, and how many of them fewer than half of its runs chose (``not_confirmed``), so that they are not given. Names
        that are refused count even if they were too doubtful to be given without the split.
    """
    every: Any = sets
    diagnosed = every[(every["status"] == "diagnosed") & (every["status_split"] == "diagnosed")]
    numbers: dict[str, Any] = {"sets": len(diagnosed)}
    for error, (stated, true) in ERRORS.items():
        ratio = (diagnosed[true] / diagnosed[stated]).to_numpy(dtype=float)
        ratio = ratio[np.isfinite(ratio)]
        numbers[error] = {
            "sets": len(ratio),
            **{
                f"true_over_stated_{100 * q:.0f}": float(np.quantile(ratio, q))
                for q in QUANTILES
                if len(ratio)
            },
            "covered": int((ratio <= 1.0).sum()),
            "covered_within_a_tenth": int((ratio <= TENTH_LARGER).sum()),
        }
    return numbers | refused_names(diagnosed)


def refused_names(sets: pd.DataFrame) -> dict[str, dict[str, int]]:
    """Return how many wrong and right names the split finds, and how many of them it does not confirm, as ``split_numbers`` describes them."""
    counts = {kind: {"names": 0, "not_confirmed": 0} for kind in ("wrong_names", "right_names")}
    for row in sets.to_dict("records"):
        truth = truth_in(row)
        for entry in [*json.loads(row["found_split"]), *json.loads(row["not_confirmed"])]:
            if entry["name"] == UNATTRIBUTED or entry.get("selected_in") is None:
                continue
            right = acceptable(entry, truth) or listed(entry, truth)
            of_kind = counts["right_names" if right else "wrong_names"]
            of_kind["names"] += 1
            of_kind["not_confirmed"] += entry["selected_in"] < HALF
    return counts
