"""Score the answer to a set of the real-arm trials: the effect that is judged, wrong names, false alarms, and whether the correction helps.

A name is right if the effect and its joints are those of an injected one, as ``study.tracked_trials.score`` says. The error of one joint over two
angles has no name, and is rightly answered by a flexible term (``unattributed``).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from study.blind_trials.score import SURE, UNATTRIBUTED, Entry
from study.blind_trials.stratified_score import WORSE
from study.real_arm_trials.design import NONE
from study.tracked_trials.score import cause_outcome, is_cause, is_true_jitter

OF_EFFECTS = {
    "right": "the effect that is judged is named with its place, or reported as unmodelled structure if it has none",
    "listed": "it is not, but a named effect is said to be confounded with it, or it is said to be unobservable",
    "unattributed": "neither, and unmodelled structure is reported",
    "missed": "nothing is said of it",
}
"""``{rate: when a set with an effect counts to it}``; a set that was diagnosed counts to one of them."""
OF_ALL = {
    "wrong": "an effect is named that was not injected, and no injected one is listed as confounded with it",
    "wrong_sure": "an effect is wrongly named with a confidence of 0.8 or more",
    "worse": "the error of the shipped model at unseen poses is more than 5 % larger than without effects",
    "failed": "the diagnosis ended in an error",
}
"""``{rate: when a set counts to it}``."""
OF_NULLS = {
    "false_alarm": "an effect is named, or unmodelled structure is reported, although nothing was injected"
}
"""``{rate: when a set without effects counts to it}``."""
RATES = {**OF_EFFECTS, **OF_ALL, **OF_NULLS}


def real_arm_score(row: Mapping[str, Any]) -> dict[str, bool]:
    """Return the columns ``RATES`` of the row of one set; those that do not apply to it are False."""
    injected, found, unobservable = (json.loads(row[key]) for key in ("injected", "found", "unobservable"))
    diagnosed, repeats = row["status"] == "diagnosed", row["repeatability_rad"] == 0
    told = [entry for entry in found if not is_true_jitter(entry, repeats)]
    wrong = wrong_names(injected, told)
    said = outcome(injected[0], found, unobservable) if diagnosed and row["effect"] != NONE else ""
    return {
        **{rate: said == rate for rate in OF_EFFECTS},
        "wrong": bool(wrong),
        "wrong_sure": any((entry.get("confidence") or 0.0) >= SURE for entry in wrong),
        "worse": diagnosed and row["unseen_after_mm"] > WORSE * row["unseen_before_mm"],
        "failed": not diagnosed,
        "false_alarm": row["effect"] == NONE and bool(told),
    }


def wrong_names(injected: Sequence[Entry], found: Sequence[Entry]) -> list[Entry]:
    """Return the named entries of diagnosis.json that are no injected effect, and do not list one as confounded."""
    return [
        entry
        for entry in found
        if entry["name"] != UNATTRIBUTED
        and not any(is_cause(e, c) for e in (entry, *entry.get("confounded_with", ())) for c in injected)
    ]


def outcome(effect: Entry, found: Sequence[Entry], unobservable: Sequence[Entry]) -> str:
    """Return to which of ``OF_EFFECTS`` a set with this effect counts."""
    said = cause_outcome(effect, found, unobservable)
    if said == "missed" and any(entry["name"] == UNATTRIBUTED for entry in found):
        return UNATTRIBUTED
    return "listed" if said == "unobservable" else said
