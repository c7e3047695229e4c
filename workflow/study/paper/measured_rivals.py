"""Count in how many halves of the measured campaigns the diagnosis or learned compensation is ahead."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isclose
from typing import Any

from study.blind_trials.stratified_score import WORSE

LEARNERS = ("gaussian_process", "network")


def counts(sets: Mapping[str, Any]) -> dict[str, Any]:
    """Return the number of halves, and of those in which predictions at unseen poses are better or worse by a factor of more than ``WORSE``.

    ``campaigns``: number of them. ``ahead``: the diagnosis has a smaller error than every learner; ``behind``: a larger one than the best learner,
    and ``behind_sets`` are the campaigns with such a half; ``harmful`` and ``learned_harmful``: the diagnosis, or a learner, has a larger error
    than geometry alone; ``*_within``: at poses within the ranges of the joints that were learned from. ``learned_nothing``: every learner leaves
    the error of the geometry as it is. ``stated_mm``: the least and the greatest error within the joint limits that the diagnosis of a half
    states. ``stated_too_small``: halves in which that is smaller, by more than the factor, than the error of the diagnosis at the unseen poses
    within the ranges.

    Args:
        sets: ``sets`` of the summary that benchmarks/diagnosis/measured.py writes.
    """
    halves: list[Mapping[str, Any]] = [half for content in sets.values() for half in content["halves"]]

    def count(which: Any) -> int:
        return sum(map(bool, map(which, halves)))

    def best(half: Mapping[str, float], where: str = "") -> float:
        return min(half[f"{name}{where}_mm"] for name in LEARNERS)

    def behind(half: Mapping[str, float]) -> bool:
        return half["diagnosis_mm"] > WORSE * best(half)

    stated = [half["stated_mm"] for half in halves if half["stated_mm"] is not None]
    return {
        "campaigns": len(sets),
        "halves": len(halves),
        "ahead": count(lambda half: WORSE * half["diagnosis_mm"] < best(half)),
        "ahead_within": count(lambda half: WORSE * half["diagnosis_within_mm"] < best(half, "_within")),
        "behind": count(behind),
        "behind_within": count(lambda half: half["diagnosis_within_mm"] > WORSE * best(half, "_within")),
        "behind_sets": [name for name, content in sets.items() if any(map(behind, content["halves"]))],
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
        "stated_too_small": count(
            lambda half: (half["stated_mm"] or inf) * WORSE < half["diagnosis_within_mm"]
        ),
        "stated_mm": {
            "least": min(stated, default=None),
            "greatest": max(stated, default=None),
        },
    }
