"""What answers are worth: errors after the diagnosis against the matched control, shares of right answers, unobservable effects, wrong answers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.score import same_target
from study.blind_trials.summaries import NATURAL, Frame, in_words, median, of_kind, quantile, share

HIDDEN = 0.02  # of the noise: a residual that is too small to be found in some hundred scans
EDGES_P = (
    0.0,
    1e-12,
    1e-6,
    1e-4,
    1.0,
)  # edges of the bins of p values for which shares of right answers are counted
EDGES_CONFIDENCE = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0)
MEANS = ("before", "after", "control")
HELD_OUT = ("before", "after", "noise_floor")


def position_errors(judged: Frame) -> pd.DataFrame:
    """Return a row for each case and size: mean position errors over the evaluation poses, medians over the sets named right."""
    rows = []
    by: Any = ["case", "size"]
    for (case, size), group in judged[judged["status"] == "diagnosed"].groupby(by, sort=False):
        kind = group["kind"].iloc[0]
        good = group[group["matched"] == 2] if kind == "pair" else group[group["outcome"] == "right"]
        good = group if kind == "null" else good
        values = {when: good[f"position_{when}_mm"].to_numpy(dtype=float) for when in MEANS}
        largest = {when: good[f"position_max_{when}_mm"].to_numpy(dtype=float) for when in MEANS}
        with np.errstate(invalid="ignore"):
            ratio = values["after"] / values["control"]
            gain = values["before"] / values["after"]
        rows.append(
            {"case": case, "size": size, "sets": len(good)}
            | {f"mean_{when}_mm": median(values[when]) for when in MEANS}
            | {f"max_{when}_mm": median(largest[when]) for when in MEANS}
            | {"after_over_control": median(ratio), "after_over_control_p95": quantile(ratio, 0.95)}
            | {"before_over_after": median(gain)}
            | {f"held_out_{w}_mm": median(good[f"held_out_{w}_mm"].to_numpy(dtype=float)) for w in HELD_OUT}
        )
    return pd.DataFrame(rows)


def reliability(found: Frame) -> pd.DataFrame:
    """Return the share of the named effects that were injected, grouped by what the diagnosis says of them.

    ``by`` is what they are grouped by: the p value, the stated confidence, whether other effects are listed as
    confounded. ``listed`` counts those not injected whose list of confounded effects holds an injected one.
    """
    names: Any = found[found["name"] != "unattributed"]
    rows = []
    for by, edges in (("p_value", EDGES_P), ("confidence", EDGES_CONFIDENCE)):
        values = names[by].to_numpy(dtype=float)
        for low, high in pairwise(edges):
            inside = (values > low) & (values <= high) if low else (values >= low) & (values <= high)
            if inside.any():
                rows.append({"by": by, "low": low, "high": high} | _right(names[inside], by))
    for by, some in (("alone", names["alternatives"] == 0), ("with alternatives", names["alternatives"] > 0)):
        rows.append({"by": by, "low": None, "high": None} | _right(names[some], "confidence"))
    return pd.DataFrame(rows)


def _right(group: Any, by: str) -> dict[str, Any]:
    mean = group[by].to_numpy(dtype=float)
    counted = share(group["right"].to_numpy(dtype=bool), "right_")
    counted = {key.replace("right_sets", "answers"): value for key, value in counted.items()}
    mean_stated = float(np.mean(mean)) if len(mean) and np.isfinite(mean).all() else None
    return {"mean_stated": mean_stated} | counted | {"listed": int((group["listed"] & ~group["right"]).sum())}


def wrong_answers(judged: Frame) -> pd.DataFrame:
    """Return every set whose answer names what is not injected, with its seed, to be looked into."""
    rows: Any = judged[judged["outcome"].isin(["wrong", "elsewhere", "listed"]) | judged["alarm"]]
    table = []
    for row in rows.to_dict("records"):
        injected, found = json.loads(row["injected"]), json.loads(row["found"])
        table.append(
            {key: row[key] for key in ("case", "workcell", "seed", "size", "outcome", "signal_over_noise")}
            | {"injected": "; ".join(f"{p['name']} {in_words(p['target'])}".strip() for p in injected)}
            | {"found": "; ".join(f"{f['name']} {in_words(f['target'])}".strip() for f in found)}
            | {"confounded_with": len(found[0].get("confounded_with", ())) if found else 0}
            | {"p_value": found[0].get("p_value") if found else None}
        )
    columns = ["case", "workcell", "seed", "size", "outcome", "signal_over_noise", "injected", "found"]
    return pd.DataFrame(table, columns=[*columns, "confounded_with", "p_value"])


def unobservable(judged: Frame) -> pd.DataFrame:
    """Return a row for each case: effects of the natural size that leave no residual, and whether the diagnosis says so.

    ``hidden`` sets are those whose signal is below ``HIDDEN`` of the noise; ``declared`` of them list the effect and
    its target as unobservable. ``seen_declared`` counts sets that do leave a residual and are declared unobservable all the same.
    """
    rows = []
    sets = of_kind(judged, "single")
    sets = sets[(sets["size"] == NATURAL) & (sets["status"] == "diagnosed")]
    for case, group in sets.groupby("case", sort=False):
        hidden = group["signal_over_noise"] < HIDDEN
        declared = np.array([_declared(row) for row in group.to_dict("records")], dtype=bool)
        rows.append(
            {
                "case": case,
                "hidden": int(hidden.sum()),
                "declared": int((hidden & declared).sum()),
                "hidden_and_named_otherwise": int(
                    (hidden & (group["outcome"].isin(["wrong", "elsewhere"]))).sum()
                ),
                "seen": int((~hidden).sum()),
                "seen_declared": int((~hidden & declared).sum()),
                "hidden_after_over_control": median(
                    (group["position_after_mm"] / group["position_control_mm"])[hidden].to_numpy(dtype=float)
                ),
            }
        )
    return pd.DataFrame(rows)


def _declared(row: Mapping[str, Any]) -> bool:
    injected = json.loads(row["injected"])[0]
    return any(
        e["name"] == injected["name"] and same_target(e, injected) for e in json.loads(row["unobservable"])
    )
