"""Of the confounded pairs that any choice of as many poses can separate, how many do the planned poses separate, and how many random ones?"""

from __future__ import annotations

from typing import Any

import pandas as pd

from scalar.planning.separation import ANSWERED
from study.blind_trials.statistics import clustered

_ANSWERED = ANSWERED**0.5  # standard errors

WAYS = {
    "expected_planned": "separated",
    "expected_random": "separated_at_random",
    "diagnosed_planned": "distinguished",
    "diagnosed_random": "distinguished_at_random",
}
"""What is counted of the separable pairs: what is expected, and what the diagnosis with the further poses says."""


def separation_numbers(pairs: pd.DataFrame) -> dict[str, Any]:
    """Return shares of the separable pairs with their intervals, which draw whole workcells and seeds anew.

    Args:
        pairs: Columns ``SEPARATION_COLUMNS``.
    """
    table: Any = pairs
    sets = ["case", "workcell", "seed", "size"]
    confounded = table[table["pairs"] > 0]
    numbers: dict[str, Any] = {
        "sets": len(table.groupby(sets)),
        "sets_with_pairs": len(confounded.groupby(sets)),
        "pairs": len(confounded),
    }
    # Pairs that the poses at hand separate already, by this measure, are no test of a plan.
    still_open = confounded[confounded["now"] < _ANSWERED]
    for name, column in (("separable", "separable"), ("separable_by_all", "separable_by_all")):
        part = still_open[still_open[column].astype(bool)]
        scenes = [f"{w} {s}" for w, s in zip(part["workcell"], part["seed"], strict=True)]
        numbers[name] = {"pairs": len(part), "scenes": len(set(scenes))} | {
            way: _share(part[hit].astype(float).to_numpy(), scenes) for way, hit in WAYS.items()
        }
    return numbers


def _share(hits: Any, scenes: list[str]) -> dict[str, Any]:
    if not len(hits):
        return {"count": 0, "share": None, "low": None, "high": None}
    low, high = clustered(hits, scenes)
    return {"count": int(hits.sum()), "share": float(hits.mean()), "low": low, "high": high}
