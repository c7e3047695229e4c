"""Tabulate what the answers of the blind trials are worth to a user.

The tables compare the errors after the diagnosis with those of the matched control, and state how often answers are right, whether unobservable
effects are declared as such, and which answers are wrong.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.score import same_target
from study.blind_trials.summaries import NATURAL, Frame, in_words, median, of_kind, quantile, share

HIDDEN = 0.02
"""Signal over noise below which the residual of an effect is too small to be found in some hundred scans."""
EDGES_P = (0.0, 1e-12, 1e-6, 1e-4, 1.0)
"""Edges of the bins of p values for which shares of right answers are counted."""
EDGES_CONFIDENCE = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0)
"""Edges of the bins of the stated confidence."""
MEANS = ("before", "after", "control")
"""Calibrations whose errors over the evaluation poses are compared."""
HELD_OUT = ("before", "after", "noise_floor")
"""What the RMS errors over held-out poses are stated for."""


def position_errors(judged: Frame) -> pd.DataFrame:
    """Return a row for each case and size: position errors [mm] over the evaluation poses, and their ratios, as medians over sets.

    The sets are those whose answer is right: of pairs those of which both effects are named, and of cases without an effect all.
    """
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
    """Return the share of the named effects that were injected, in groups by what the diagnosis states of each.

    ``by`` says how they are grouped: by the p value or the stated confidence between ``low`` and ``high``, or by whether other effects are listed as
    confounded (``alone``, ``with alternatives``). ``listed`` counts named effects that were not injected, but list an injected one as confounded.
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
    """Return the mean of the column ``by`` over a group of named effects, and how many of them are right."""
    stated = group[by].to_numpy(dtype=float)
    counted = share(group["right"].to_numpy(dtype=bool), "right_")
    counted = {key.replace("right_sets", "answers"): value for key, value in counted.items()}
    mean_stated = float(np.mean(stated)) if len(stated) and np.isfinite(stated).all() else None
    return {"mean_stated": mean_stated} | counted | {"listed": int((group["listed"] & ~group["right"]).sum())}


def wrong_answers(judged: Frame) -> pd.DataFrame:
    """Return a row for each set whose answer names something that was not injected, with its seed, so that it can be examined."""
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
    """Return a row for each case: how many sets with an effect of the natural size leave no residual, and whether the diagnosis says so.

    ``hidden`` counts the sets whose signal over noise is below ``HIDDEN``, ``declared`` those among them in which the diagnosis lists the effect and
    its target as unobservable. ``seen`` counts the other sets, which do leave a residual, and ``seen_declared`` those among them in which the effect
    is listed as unobservable nevertheless.
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
    """Return whether the diagnosis of a set lists the injected effect as unobservable."""
    injected = json.loads(row["injected"])[0]
    return any(
        e["name"] == injected["name"] and same_target(e, injected) for e in json.loads(row["unobservable"])
    )
