"""Compare what a diagnosis found with what was injected, by name and by target.

An answer is judged by the effect that was selected first. Its outcome is one of these:

- ``right``: its name and its target are those of the injected effect.
- ``listed``: it is another effect, but its entry ``confounded_with`` contains the injected one.
- ``elsewhere``: its name is right, but it is at another joint, order, target plane or moment.
- ``wrong``: it has another name, and the injected effect is not listed.
- ``unattributed``: it is unmodelled structure.
- ``unobservable``: nothing was found, and the injected effect is listed as one that these data cannot observe.
- ``missed``: nothing was found, and the injected effect is not listed either.
- ``failed``: there is no diagnosis.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

OUTCOMES = ("right", "listed", "unattributed", "unobservable", "missed", "elsewhere", "wrong", "failed")
NOISES = ("pose_jitter", "scan_bias")
"""Variance components: random errors of mean zero. Every other name stands for a systematic effect."""
NONE, UNATTRIBUTED = "none", "unattributed"
SURE = 0.8
"""Stated confidence from which on a user is expected to act upon an answer, so that a wrong name does harm."""
SLACK_POSES = 10
"""Number of poses by which the moment of a change may be off in a right answer."""

Entry = Mapping[str, Any]
"""An entry of diagnosis.json or truth.json: ``name``, ``target`` and further keys."""


def same_target(found: Entry, injected: Entry) -> bool:
    """Return whether two entries of the same name state the same target.

    A compliance may leave out injected joints, since the data may hardly load them, but may not add a joint; a harmonic must have the same joint and
    exactly the injected orders; a moment may be off by ``SLACK_POSES``.
    """
    a, b = found.get("target") or {}, injected.get("target") or {}
    if "joints" in b:
        joints = set(a.get("joints") or [a.get("joint")])
        return bool(joints) and joints <= set(b["joints"])
    if found["name"] == "joint_harmonic":
        return a.get("joint") == b.get("joint") and _orders(a) == _orders(b)
    if "at" in b and ("at" not in a or abs(a["at"]["order"] - b["at"]["order"]) > SLACK_POSES):
        return False
    return all(a.get(key) == value for key, value in b.items() if key != "at")


def _orders(target: Mapping[str, Any]) -> set[int]:
    """Return the orders of a harmonic's target, which states one or several."""
    return set(target["orders"]) if "orders" in target else {target.get("order")}  # type: ignore[arg-type]


def same(found: Entry, injected: Entry) -> bool:
    """Return whether an entry is an injected effect, by name and target; an effect without a name (``unknown``) is answered by ``unattributed``."""
    if injected["name"] == "unknown":
        return found["name"] == UNATTRIBUTED
    return found["name"] == injected["name"] and same_target(found, injected)


def first_name(found: Sequence[Entry]) -> str:
    """Return the name of the first effect found, or ``none``."""
    return found[0]["name"] if found else NONE


def outcome(injected: Entry, found: Sequence[Entry], unobservable: Sequence[Entry]) -> str:
    """Return the outcome of a diagnosis of a set with one injected effect, one of ``OUTCOMES``.

    Args:
        injected: The injected effect.
        found: The entries ``effects`` of diagnosis.json.
        unobservable: The entries ``unobservable`` of diagnosis.json.
    """
    if not found:
        hidden = any(
            entry["name"] == injected["name"] and same_target(entry, injected) for entry in unobservable
        )
        return "unobservable" if hidden else "missed"
    first = found[0]
    if same(first, injected):
        return "right"
    if any(same(other, injected) for other in first.get("confounded_with", ())):
        return "listed"
    if first["name"] == UNATTRIBUTED:
        return "unattributed"
    return "elsewhere" if first["name"] == injected["name"] else "wrong"


def judged(sets: pd.DataFrame) -> pd.DataFrame:
    """Return the sets with these columns added.

    ``named`` is the name of the first effect found; ``outcome`` one of ``OUTCOMES``, or empty if not exactly one effect was injected; ``matched`` the
    number of injected effects that were found; ``extra`` the number of effects found that were not injected; and ``alarm`` whether a systematic
    effect or ``unattributed`` is among these.
    """
    rows = []
    for row in sets.to_dict("records"):
        injected, found, unobservable = (
            json.loads(row[key]) for key in ("injected", "found", "unobservable")
        )
        answered = row["status"] == "diagnosed"
        verdict = "failed"
        if answered and len(injected) == 1:
            verdict = outcome(injected[0], found, unobservable)
        elif answered:
            verdict = ""
        extra = [f for f in found if not any(same(f, p) for p in injected)]
        rows.append(
            {
                "named": first_name(found) if answered else "failed",
                "outcome": verdict,
                "matched": sum(any(same(f, p) for f in found) for p in injected),
                "extra": len(extra),
                "alarm": any(f["name"] not in NOISES for f in extra),
            }
        )
    return pd.concat([sets.reset_index(drop=True), pd.DataFrame(rows)], axis=1)


def findings(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each finding of all sets: its name and target, its p value and confidence if they are stated, and whether it was injected.

    ``place`` is its place in the order of selection, from 0; ``alternatives`` the number of effects in its entry ``confounded_with``, and ``listed``
    says whether an injected effect is among them.
    """
    rows = []
    for row in sets.to_dict("records"):
        injected = json.loads(row["injected"])
        for place, entry in enumerate(json.loads(row["found"])):
            others = entry.get("confounded_with", ())
            rows.append(
                {
                    "case": row["case"],
                    "workcell": row["workcell"],
                    "seed": row["seed"],
                    "size": row["size"],
                    "place": place,
                    "name": entry["name"],
                    "target": json.dumps(entry.get("target", {})),
                    "p_value": entry.get("p_value"),
                    "confidence": entry.get("confidence"),
                    "alternatives": len(others),
                    "right": any(same(entry, p) for p in injected),
                    "listed": any(same(other, p) for other in others for p in injected),
                }
            )
    columns = ["case", "workcell", "seed", "size", "place", "name", "target", "p_value", "confidence"]
    return pd.DataFrame(rows, columns=[*columns, "alternatives", "right", "listed"])
