"""The table of the stratified blind trials: rates with intervals, a row a kind of set, and how sure answers may be."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.statistics import wilson

ROWS = (
    "no effect, ideal",
    "no effect, imperfect",
    "one effect, ideal",
    "one effect, imperfect",
    "3 to 5 effects",
    "60 poses",
    "unknown cause",
    "shape also tried",
)
RATES = (
    "clean", "missed", "wrong", "wrong_sure", "wrong_noise", "unattributed", "sure_structure", "fair", "flaw_unseen", "worse",
    "much_worse", "failed",
)  # fmt: skip
RATIOS = ("after_over_floor", "after_over_before")
QUANTILES = (0.5, 0.95, 1.0)
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 1.0)
DRAWS, LEVEL, SEED = 1000, 0.95, 20_261_122  # of the bootstrap


def table(scored: pd.DataFrame) -> pd.DataFrame:
    """Return a row a kind of set and rate: count, share and its 95 % interval (Wilson's; each set is a scene of its own)."""
    rows = []
    for row, group in _groups(scored):
        for rate in RATES:
            hits = int(group[rate].sum())
            low, high = wilson(hits, len(group))
            rows.append(
                {"row": row, "rate": rate, "sets": len(group), "count": hits, "share": hits / len(group)}
                | {"low": low, "high": high}
            )
    return pd.DataFrame(rows)


def ratios(scored: pd.DataFrame) -> pd.DataFrame:
    """Return quantiles of after over floor and after over before, a row a kind of set, with intervals by drawing scenes anew."""
    rows = []
    rng = np.random.default_rng(SEED)
    for row, group in _groups(scored):
        for ratio in RATIOS:
            values = group[ratio].to_numpy(dtype=float)
            drawn = values[rng.integers(len(values), size=(DRAWS, len(values)))]
            for q in QUANTILES:
                low, high = np.quantile(np.quantile(drawn, q, axis=1, method="higher"), [0.5 - LEVEL / 2, 0.5 + LEVEL / 2],
                                        method="nearest")  # fmt: skip
                value = float(np.quantile(values, q, method="higher"))
                rows.append(
                    {"row": row, "ratio": ratio, "quantile": q, "value": value, "low": low, "high": high}
                )
    return pd.DataFrame(rows)


def confidence_bins(answers: pd.DataFrame) -> pd.DataFrame:
    """Return of the answers with a stated confidence the share that is right, by bins, effects and components apart."""
    rows = []
    for of in ("effect", "component"):
        some: Any = answers[answers["of"] == of]
        stated = some["confidence"].to_numpy(dtype=float)
        for low, high in pairwise(BINS):
            inside = (stated >= low) & ((stated < high) | ((high == BINS[-1]) & (stated <= high)))
            n, right = int(inside.sum()), int(some["right"].to_numpy(dtype=bool)[inside].sum())
            bottom, top = wilson(right, n)
            mean = float(stated[inside].mean()) if n else None
            rows.append(
                {"of": of, "from": low, "to": high, "answers": n, "mean_stated": mean, "right": right}
                | {"share": right / n if n else None, "low": bottom, "high": top}
            )
    return pd.DataFrame(rows)


def _groups(scored: pd.DataFrame) -> list[tuple[str, Any]]:
    known = [(row, scored[scored["row"] == row]) for row in ROWS]
    return [(row, group) for row, group in known if len(group)] + [("all", scored)]
