"""Score the answer to a set of the tracked trials: what is right, missed and wrong, and whether the correction helps at unseen poses.

A name is right if the effect and its joints are those of an injected cause. A compliance of several joints may leave some of them out, a harmonic
may have further orders, and ``pose_jitter`` is right if the joints do not repeat exactly. A cause that is no effect of the catalogue (``unknown``)
is rightly answered by ``unattributed``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from study.blind_trials.score import SURE, UNATTRIBUTED, Entry, same, same_target
from study.blind_trials.stratified_score import WORSE

RATES = {
    "clean": "every cause is named, and nothing else",
    "missed": "a cause is neither named, nor listed as confounded or unobservable, nor reported as unattributed structure",
    "wrong": "an effect is named that was not injected, and no injected cause is listed as confounded with it",
    "wrong_sure": "an effect is wrongly named with a confidence of 0.8 or more",
    "unattributed": "unmodelled structure is reported",
    "worse": "the error of the shipped model at unseen poses is more than 5 % larger than without effects",
    "failed": "the diagnosis ended in an error",
}
"""``{column of a score: when it is True}``; several may be True for one set."""


def is_cause(entry: Entry, cause: Mapping[str, Any]) -> bool:
    """Return whether an entry of diagnosis.json names a cause."""
    if entry["name"] == cause["name"] == "joint_harmonic":
        target = entry["target"]
        orders = target.get("orders") or [target.get("order")]
        return target.get("joint") == cause["target"]["joint"] and cause["target"]["order"] in orders
    return same(entry, cause)


def is_true_jitter(entry: Entry, repeats: bool) -> bool:
    """Return whether an entry names a jitter of poses, and the joints do not return exactly to a pose (``repeats`` is False)."""
    return entry["name"] == "pose_jitter" and not repeats


def tracked_score(
    causes: Sequence[Mapping[str, Any]],
    repeats: bool,
    found: Sequence[Entry],
    unobservable: Sequence[Entry],
    errors: Mapping[str, float | None],
) -> dict[str, bool]:
    """Return the columns ``RATES`` of one set.

    Args:
        causes: The injected causes.
        repeats: Whether the joints return exactly to a pose.
        found: The entries ``effects`` of diagnosis.json.
        unobservable: The entries ``unobservable`` of diagnosis.json.
        errors: ``before`` and ``after``, the RMS errors over unseen poses [mm]; None without an answer.
    """
    unattributed = any(entry["name"] == UNATTRIBUTED for entry in found)
    wrong = [
        entry
        for entry in found
        if entry["name"] != UNATTRIBUTED
        and not is_true_jitter(entry, repeats)
        and not any(is_cause(e, c) for e in (entry, *entry.get("confounded_with", ())) for c in causes)
    ]
    outcomes = [cause_outcome(cause, found, unobservable) for cause in causes]
    before, after = errors["before"], errors["after"]
    failed = before is None or after is None
    needless = unattributed and not any(cause["name"] == "unknown" for cause in causes)
    return {
        "clean": not failed
        and not wrong
        and not needless
        and all(outcome == "right" for outcome in outcomes),
        "missed": not failed and not unattributed and "missed" in outcomes,
        "wrong": bool(wrong),
        "wrong_sure": any((entry.get("confidence") or 0.0) >= SURE for entry in wrong),
        "unattributed": unattributed,
        "worse": before is not None and after is not None and after > WORSE * before,
        "failed": failed,
    }


def cause_outcome(cause: Mapping[str, Any], found: Sequence[Entry], unobservable: Sequence[Entry]) -> str:
    """Return ``right``, ``listed`` (as confounded with a named effect), ``unobservable`` (listed as such) or ``missed``."""
    if any(is_cause(entry, cause) for entry in found):
        return "right"
    if any(is_cause(other, cause) for entry in found for other in entry.get("confounded_with", ())):
        return "listed"
    hidden = any(entry["name"] == cause["name"] and same_target(entry, cause) for entry in unobservable)
    return "unobservable" if hidden else "missed"
