"""The tables of the blind trials on the answers: what was named for which effect, and how large an effect must be to be named right.

They are small enough to be committed. Each function takes the judged sets (``score.judged``) and returns one table.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.cases import Study
from study.blind_trials.score import NOISES, OUTCOMES
from study.blind_trials.statistics import half_point, half_point_interval, wilson

Frame = Any  # a pandas.DataFrame; the type stubs of pandas do not state what the columns contain
NATURAL = 1.0  # the natural size, which real arms have: sizes are stated as multiples of it


def share(hits: Any, prefix: str = "") -> dict[str, Any]:
    """Return the number of sets, the number and the share of those that are hits, and Wilson's interval of the share.

    Args:
        hits: ``(n,)`` bool, whether each set is a hit.
        prefix: Put before the names of the entries.
    """
    n, k = len(hits), int(np.sum(hits))
    low, high = wilson(k, n)
    return {
        f"{prefix}sets": n,
        f"{prefix}count": k,
        f"{prefix}share": k / n if n else None,
        f"{prefix}low": low,
        f"{prefix}high": high,
    }


def of_kind(judged: Frame, kind: str) -> Any:
    """Return the sets of one kind that could be simulated."""
    return judged[(judged["kind"] == kind) & (judged["status"] != "not_simulated")]


def confusion(judged: Frame) -> pd.DataFrame:
    """Return how often which effect was named first, for sets with one injected effect: columns ``case, injected, size, named, count``."""
    rows: Any = judged[judged["kind"].isin(["single", "unknown"]) & (judged["status"] != "not_simulated")]
    rows = rows.assign(injected=[_only(entry) for entry in rows["injected"]])
    table = rows.groupby(["case", "injected", "size", "named"], sort=False).size()
    return table.rename("count").reset_index()


def _only(injected: str) -> str:
    """Return the name of the only injected effect, from JSON."""
    return json.loads(injected)[0]["name"]


def power(judged: Frame, study: Study) -> pd.DataFrame:
    """Return a row for each case and size of the single effects: how large the effect is, and how often each outcome occurs.

    ``found_later`` counts the sets in which the injected effect is named, but not first; ``with_more`` those in which it is named first and another
    effect, which was not injected, is named too.
    """
    rows = []
    by: Any = ["case", "size"]
    for (case, size), group in of_kind(judged, "single").groupby(by, sort=False):
        natural = study.cases[case].choices[0].natural
        signal = group["signal_over_noise"].to_numpy(dtype=float)
        rows.append(
            {
                "case": case,
                "size": size,
                "size_in_unit": size * natural,
                "unit": study.units[case],
                "signal_over_noise": median(signal),
                **share(group["outcome"] == "right", "right_"),
                **{name: int((group["outcome"] == name).sum()) for name in OUTCOMES},
                "found_later": int(((group["outcome"] != "right") & (group["matched"] > 0)).sum()),
                "with_more": int(((group["outcome"] == "right") & (group["extra"] > 0)).sum()),
            }
        )
    return pd.DataFrame(rows)


def thresholds(judged: Frame, study: Study) -> pd.DataFrame:
    """Return the size, and the signal over noise, at which each effect is named right in half of the sets, with 95 % intervals.

    0 stands for a value below the smallest one that was tried, an empty cell for a value above the largest.
    """
    rows = []
    for case, group in of_kind(judged, "single").groupby("case", sort=False):
        natural = study.cases[case].choices[0].natural
        right = (group["outcome"] == "right").to_numpy(dtype=float)
        seeds = [
            f"{workcell} {seed}" for workcell, seed in zip(group["workcell"], group["seed"], strict=True)
        ]
        row: dict[str, Any] = {
            "case": case,
            "unit": study.units[case],
            "seeds": len(set(seeds)),
            "sets": len(group),
        }
        for name, x, scale in (
            ("size", group["size"].to_numpy(dtype=float), natural),
            ("signal", group["signal_over_noise"].to_numpy(dtype=float), 1.0),
        ):
            seen = np.isfinite(x) & (x > 0)
            low, high = half_point_interval(
                x[seen], right[seen], [s for s, ok in zip(seeds, seen, strict=True) if ok]
            )
            row |= {
                f"half_{name}": half_point(x[seen], right[seen]) * scale,
                f"half_{name}_low": low * scale,
                f"half_{name}_high": high * scale,
            }
        rows.append(row)
    return pd.DataFrame(rows)


def nulls(judged: Frame) -> pd.DataFrame:
    """Return how often a systematic effect is named although none was injected: a row for each case without an effect, and one for all."""
    rows = []
    sets = of_kind(judged, "null")
    for case, group in [*sets.groupby("case", sort=False), ("all", sets)]:
        spoiled = group["wrong_poses"].sum()
        rows.append(
            {
                "case": case,
                **share(group["alarm"]),
                "failed": int((group["status"] != "diagnosed").sum()),
                "wrong_poses": int(spoiled),
                "wrong_poses_set_aside": int(group["wrong_poses_found"].sum()),
            }
        )
    return pd.DataFrame(rows)


def pairs(judged: Frame) -> pd.DataFrame:
    """Return a row for each set with two injected effects: these effects, how many of them were named, and all that was named."""
    rows = []
    for row in of_kind(judged, "pair").to_dict("records"):
        first, second = (
            f"{entry['name']} {in_words(entry['target'])}".strip() for entry in json.loads(row["injected"])
        )
        answers = [
            f"{entry['name']} {in_words(entry['target'])}".strip() for entry in json.loads(row["found"])
        ]
        rows.append(
            {key: row[key] for key in ("workcell", "seed", "size")}
            | {"first": first, "second": second, "matched": row["matched"], "extra": row["extra"]}
            | {"found": "; ".join(answers)}
        )
    return pd.DataFrame(rows)


def in_words(target: Mapping[str, Any] | None) -> str:
    """Return a target as a short text, such as ``joint 4, order 2``."""
    if not target:
        return ""
    parts = []
    for key, value in target.items():
        if key == "at":
            parts.append(f"at {value['order']:g}")
        elif isinstance(value, list):
            parts.append(f"{key} {' '.join(map(str, value))}")
        else:
            parts.append(f"{key} {value}")
    return ", ".join(parts)


def unknown(judged: Frame) -> pd.DataFrame:
    """Return a row for each kind and size of effects without a name: how often they are called unattributed, given a name, or taken for noise."""
    rows = []
    by: Any = ["case", "size"]
    for (case, size), group in of_kind(judged, "unknown").groupby(by, sort=False):
        verdict = group["verdict"] == "unattributed"
        wrong = ~group["named"].isin(["unattributed", "none", "failed", *NOISES])
        rows.append(
            {
                "case": case,
                "size": size,
                "signal_over_noise": median(group["signal_over_noise"].to_numpy(dtype=float)),
                **share(verdict, "unattributed_"),
                "first_is_a_name": int(wrong.sum()),
                "taken_for_noise": int(group["named"].isin(NOISES).sum()),
                "nothing_found": int((group["named"] == "none").sum()),
                "failed": int((group["status"] != "diagnosed").sum()),
            }
        )
    return pd.DataFrame(rows)


def by_workcell(judged: Frame) -> pd.DataFrame:
    """Return how many sets of the natural size are named right, a row for each case and workcell."""
    rows = []
    natural = of_kind(judged, "single")
    natural = natural[natural["size"] == NATURAL]
    by: Any = ["case", "workcell"]
    for (case, workcell), group in natural.groupby(by, sort=False):
        right = int((group["outcome"] == "right").sum())
        rows.append({"case": case, "workcell": workcell, "sets": len(group), "right": right})
    return pd.DataFrame(rows, columns=["case", "workcell", "sets", "right"])


def by_scene(judged: Frame) -> pd.DataFrame:
    """Return a row for each set of one effect of the natural size: its scene (workcell and seed) and whether it was named right.

    Sets of one scene share poses and noise: intervals of shares draw whole scenes (``statistics.clustered_interval``).
    """
    natural = of_kind(judged, "single")
    natural = natural[natural["size"] == NATURAL]
    table = natural[["case", "workcell", "seed"]].reset_index(drop=True)
    return table.assign(right=(natural["outcome"] == "right").to_numpy(dtype=int))


def median(values: Any) -> float | None:
    """Return the median of the finite values; None if there are none."""
    return quantile(values, 0.5)


def quantile(values: Any, q: float) -> float | None:
    """Return a quantile of the finite values; None if there are none."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, q)) if len(finite) else None
