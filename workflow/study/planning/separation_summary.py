"""Count the confounded pairs that the planned poses separate, and those that as many random ones do, among the pairs that can be separated at all."""

from __future__ import annotations

from typing import Any

import pandas as pd

from scalar.planning.separation import ANSWERED
from study.blind_trials.statistics import clustered_interval

_ANSWERED = ANSWERED**0.5  # signal in standard errors from which on a pair counts as separated

WAYS = {
    "expected_planned": "separated",
    "expected_random": "separated_at_random",
    "diagnosed_planned": "distinguished",
    "diagnosed_random": "distinguished_at_random",
}
"""``{key of a number: column that is counted}``: what is expected of the further poses, and what the diagnosis with them says."""


def separation_numbers(pairs: pd.DataFrame) -> dict[str, Any]:
    """Return counts of sets and pairs, and shares of the separable pairs with intervals by drawing whole scenes (workcell and seed) anew.

    ``separable`` pairs are those that some choice of as many poses may separate, ``separable_by_all`` those that the whole pool is expected to
    separate.

    Args:
        pairs: The rows of all sets, columns ``SEPARATION_COLUMNS``.
    """
    table: Any = pairs
    sets = ["case", "workcell", "seed", "size"]
    confounded = table[table["pairs"] > 0]
    numbers: dict[str, Any] = {
        "sets": len(table.groupby(sets)),
        "sets_with_pairs": len(confounded.groupby(sets)),
        "pairs": len(confounded),
    }
    # Pairs that the diagnosed poses separate already, by this measure, are no test of a plan.
    still_open = confounded[confounded["now"] < _ANSWERED]
    for name, column in (("separable", "separable"), ("separable_by_all", "separable_by_all")):
        part = still_open[still_open[column].astype(bool)]
        scenes = [f"{w} {s}" for w, s in zip(part["workcell"], part["seed"], strict=True)]
        numbers[name] = {"pairs": len(part), "scenes": len(set(scenes))} | {
            way: _share(part[hit].astype(float).to_numpy(), scenes) for way, hit in WAYS.items()
        }
    return numbers


def _share(hits: Any, scenes: list[str]) -> dict[str, Any]:
    """Return count and share of hits (0 or 1), and the interval of the share; None without pairs."""
    if not len(hits):
        return {"count": 0, "share": None, "low": None, "high": None}
    low, high = clustered_interval(hits, scenes)
    return {"count": int(hits.sum()), "share": float(hits.mean()), "low": low, "high": high}
