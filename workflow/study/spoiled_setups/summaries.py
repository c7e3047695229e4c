"""Summaries of the spoiled set-ups: the outcomes for each kind of spoiling and sensor, and the numbers with the version of the code."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from study.blind_trials.statistics import wilson
from study.common.provenance import code_version, design_identity
from study.spoiled_setups.score import OUTCOMES, RIGHT

ALL = "all"  # in the columns ``kind`` and ``sensor``


def outcomes(sets: Any) -> pd.DataFrame:
    """Return a row for each kind of spoiling, each sensor, and all sets.

    Columns: ``kind``, ``sensor``, ``sets``, the number of each of ``OUTCOMES``, the share named right with Wilson's 95 % interval, and ``alone``,
    the number of sets in which the right reading is the only one named.
    """
    groups = [((kind, ALL), group) for kind, group in sets.groupby("kind", sort=False)]
    groups += [((ALL, sensor), group) for sensor, group in sets.groupby("sensor")]
    rows = []
    for (kind, sensor), group in [*groups, ((ALL, ALL), sets)]:
        counts = {name: int((group["outcome"] == name).sum()) for name in OUTCOMES}
        right = counts[RIGHT]
        low, high = wilson(right, len(group))
        row = {"kind": kind, "sensor": sensor, "sets": len(group), **counts}
        rows.append(
            row
            | {"share_right": right / len(group), "low": low, "high": high}
            | {"alone": int((group["one_of"] == 1).sum())}
        )
    return pd.DataFrame(rows)


def faults(sets: Any) -> pd.DataFrame:
    """Return the sets that are not named right, with all that is needed to draw them again, and what was said of them."""
    return sets[sets["outcome"] != RIGHT].drop(columns=["seconds"])


def summarise_spoiled(sets: Any, design: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, pd.DataFrame]]:
    """Return the numbers, and ``{name: table}`` of the summaries ``table`` and ``faults``.

    Args:
        sets: Rows of all sets, columns ``study.spoiled_setups.run.COLUMNS``.
        design: Content of the config.
    """
    table = outcomes(sets)
    overall: Any = table[(table["kind"] == ALL) & (table["sensor"] == ALL)].iloc[0]
    numbers = {
        "code": code_version(),
        "design": design_identity(design),
        "sets": len(sets),
        **{name: int(overall[name]) for name in OUTCOMES},
        "share_right": float(overall["share_right"]),
        "low": float(overall["low"]),
        "high": float(overall["high"]),
        "alone": int(overall["alone"]),
        "drawn_again": int(sets["attempt"].sum()),
        "seconds_median": float(sets["seconds"].median()),
        "seconds_most": float(sets["seconds"].max()),
    }
    return numbers, {"table": table, "faults": faults(sets)}
