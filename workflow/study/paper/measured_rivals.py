"""Count in how many halves of the measured campaigns the diagnosis or learned compensation is ahead."""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose
from typing import Any

from study.blind_trials.stratified_score import WORSE

LEARNERS = ("gaussian_process", "network")


def counts(sets: Mapping[str, Any]) -> dict[str, Any]:
    """Return the number of halves, and of those in which predictions at unseen poses are better or worse by a factor of more than ``WORSE``.

    ``ahead``: the diagnosis has a smaller error than every learner; ``behind``: a larger one than the best learner; ``harmful`` and
    ``learned_harmful``: the diagnosis, or a learner, has a larger error than geometry alone; ``*_within``: at poses within
    the ranges of the joints that were learned from. ``learned_nothing``: every learner leaves the error of the geometry as it is.
    ``stated_mm``: the least and the greatest error within the joint limits that the diagnosis of a half states.

    Args:
        sets: ``sets`` of the summary that benchmarks/diagnosis/measured.py writes.
    """
    halves = [half for content in sets.values() for half in content["halves"]]

    def count(which: Any) -> int:
        return sum(map(bool, map(which, halves)))

    def best(half: Mapping[str, float], where: str = "") -> float:
        return min(half[f"{name}{where}_mm"] for name in LEARNERS)

    return {
        "halves": len(halves),
        "ahead": count(lambda half: WORSE * half["diagnosis_mm"] < best(half)),
        "ahead_within": count(lambda half: WORSE * half["diagnosis_within_mm"] < best(half, "_within")),
        "behind": count(lambda half: half["diagnosis_mm"] > WORSE * best(half)),
        "harmful": count(lambda half: half["diagnosis_mm"] > WORSE * half["geometry_mm"]),
        "harmful_within": count(
            lambda half: half["diagnosis_within_mm"] > WORSE * half["geometry_within_mm"]
        ),
        "learned_harmful": count(
            lambda half: any(half[f"{name}_mm"] > WORSE * half["geometry_mm"] for name in LEARNERS)
        ),
        "learned_nothing": count(
            lambda half: all(isclose(half[f"{name}_mm"], half["geometry_mm"]) for name in LEARNERS)
        ),
        "stated_mm": {
            "least": min(half["stated_mm"] for half in halves),
            "greatest": max(half["stated_mm"] for half in halves),
        },
    }
