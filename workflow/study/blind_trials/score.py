"""Is an answer right? What a diagnosis found against what was injected, by name and by target.

An answer is judged by its first effect, the one that was taken first. ``right``: its name and its target are the
injected ones. ``listed``: another effect, but the injected one stands in its ``confounded_with``. ``elsewhere``: the
right name at another joint, order, target plane or moment. ``wrong``: another name, and the injected one is not listed.
``unobservable``: nothing found, and the injected effect is listed as one that these data cannot observe. ``missed``: nothing
found. ``unattributed``: unmodelled structure.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

OUTCOMES = ("right", "listed", "unattributed", "unobservable", "missed", "elsewhere", "wrong", "failed")
NOISES = (
    "pose_jitter",
    "scan_bias",
)  # random errors, of mean zero; every other name stands for a systematic effect
NONE, UNATTRIBUTED = "none", "unattributed"
SURE = 0.8  # stated confidence from which an answer is acted upon, and a wrong name is grave
SLACK_POSES = 10  # by which the moment of a change may be off

Entry = Mapping[str, Any]


def same_target(found: Entry, injected: Entry) -> bool:
    """Return whether two entries of the same name say the same place.

    A compliance may leave out joints that the data hardly load, but may name no joint that is not compliant; a harmonic
    with several orders has to hold all injected ones and no other; a moment may be off by ``SLACK_POSES``.
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
    return set(target["orders"]) if "orders" in target else {target.get("order")}  # type: ignore[arg-type]


def same(found: Entry, injected: Entry) -> bool:
    """Return whether an entry is an injected effect, by name and target."""
    if injected["name"] == "unknown":
        return found["name"] == UNATTRIBUTED
    return found["name"] == injected["name"] and same_target(found, injected)


def named(found: Sequence[Entry]) -> str:
    """Return the name of the first effect found, or ``none``."""
    return found[0]["name"] if found else NONE


def outcome(injected: Entry, found: Sequence[Entry], unobservable: Sequence[Entry]) -> str:
    """Return one of ``OUTCOMES`` for an answer about one injected effect."""
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
    """Return the sets with judgements beside them.

    Added: ``named``, the first name; ``outcome`` (of sets with one effect injected); ``matched``, how many of the
    injected are among the found; ``extra``, how many of the found are none of the injected; ``alarm``, whether a
    systematic effect, or ``unattributed``, is named that is not injected.
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
                "named": named(found) if answered else "failed",
                "outcome": verdict,
                "matched": sum(any(same(f, p) for f in found) for p in injected),
                "extra": len(extra),
                "alarm": any(f["name"] not in NOISES for f in extra),
            }
        )
    return pd.concat([sets.reset_index(drop=True), pd.DataFrame(rows)], axis=1)


def findings(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each finding of all sets: its name, p value, confidence where stated, and whether it is injected.

    ``listed`` says whether an injected effect stands in its ``confounded_with``.
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
