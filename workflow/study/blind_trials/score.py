"""Is an answer right? What a diagnosis found against what was planted, by name and by target.

An answer is judged by its first effect, the one that was taken first. ``right``: its name and its target are the
planted ones. ``listed``: another effect, but the planted one stands in its ``confounded_with``. ``elsewhere``: the
right name at another joint, order, plate or moment. ``wrong``: another name, and the planted one is not listed.
``silent``: nothing found, and the planted effect is listed as one that these data cannot show. ``missed``: nothing
found. ``unattributed``: structure without a name.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

OUTCOMES = ("right", "listed", "unattributed", "silent", "missed", "elsewhere", "wrong", "failed")
NOISES = ("pose_jitter", "scan_bias")  # they shift nothing on average
NONE, UNATTRIBUTED = "none", "unattributed"
SLACK_POSES = 10  # by which the moment of a change may be off

Entry = Mapping[str, Any]


def same_target(found: Entry, planted: Entry) -> bool:
    """Return whether two entries of the same name say the same place.

    A compliance may leave out joints that the data hardly load, but may name none that does not give; a harmonic
    with several orders has to hold all planted ones and no other; a moment may be off by ``SLACK_POSES``.
    """
    a, b = found.get("target") or {}, planted.get("target") or {}
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


def same(found: Entry, planted: Entry) -> bool:
    """Return whether an entry is a planted effect, by name and target."""
    if planted["name"] == "unknown":
        return found["name"] == UNATTRIBUTED
    return found["name"] == planted["name"] and same_target(found, planted)


def named(found: Sequence[Entry]) -> str:
    """Return the name of the first effect found, or ``none``."""
    return found[0]["name"] if found else NONE


def outcome(planted: Entry, found: Sequence[Entry], silent: Sequence[Entry]) -> str:
    """Return one of ``OUTCOMES`` for an answer about one planted effect."""
    if not found:
        hidden = any(entry["name"] == planted["name"] and same_target(entry, planted) for entry in silent)
        return "silent" if hidden else "missed"
    first = found[0]
    if same(first, planted):
        return "right"
    if any(same(other, planted) for other in first.get("confounded_with", ())):
        return "listed"
    if first["name"] == UNATTRIBUTED:
        return "unattributed"
    return "elsewhere" if first["name"] == planted["name"] else "wrong"


def judged(sets: pd.DataFrame) -> pd.DataFrame:
    """Return the sets with judgements beside them.

    Added: ``named``, the first name; ``outcome`` (of sets with one effect planted); ``matched``, how many of the
    planted are among the found; ``extra``, how many of the found are none of the planted; ``alarm``, whether a
    shift is named, or ``unattributed``, that is not planted.
    """
    rows = []
    for row in sets.to_dict("records"):
        planted, found, silent = (json.loads(row[key]) for key in ("planted", "found", "silent"))
        answered = row["status"] == "diagnosed"
        verdict = "failed"
        if answered and len(planted) == 1:
            verdict = outcome(planted[0], found, silent)
        elif answered:
            verdict = ""
        extra = [f for f in found if not any(same(f, p) for p in planted)]
        rows.append(
            {
                "named": named(found) if answered else "failed",
                "outcome": verdict,
                "matched": sum(any(same(f, p) for f in found) for p in planted),
                "extra": len(extra),
                "alarm": any(f["name"] not in NOISES for f in extra),
            }
        )
    return pd.concat([sets.reset_index(drop=True), pd.DataFrame(rows)], axis=1)


def findings(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row a finding of all sets: its name, p value, confidence where stated, and whether it is planted.

    ``listed`` says whether a planted effect stands in its ``confounded_with``.
    """
    rows = []
    for row in sets.to_dict("records"):
        planted = json.loads(row["planted"])
        for place, entry in enumerate(json.loads(row["found"])):
            others = entry.get("confounded_with", ())
            rows.append(
                {
                    "case": row["case"],
                    "cell": row["cell"],
                    "seed": row["seed"],
                    "size": row["size"],
                    "place": place,
                    "name": entry["name"],
                    "target": json.dumps(entry.get("target", {})),
                    "p_value": entry.get("p_value"),
                    "confidence": entry.get("confidence"),
                    "alternatives": len(others),
                    "right": any(same(entry, p) for p in planted),
                    "listed": any(same(other, p) for other in others for p in planted),
                }
            )
    columns = ["case", "cell", "seed", "size", "place", "name", "target", "p_value", "confidence"]
    return pd.DataFrame(rows, columns=[*columns, "alternatives", "right", "listed"])
