"""Set the errors that the authors of measured data published beside those of the diagnosis on the same poses, and count who is ahead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from study.blind_trials.stratified_score import WORSE

BEST = "interpolated"
"""The method of the Motomans' authors with which ours is compared: of their interpolations, that with the smallest mean error on the judged poses."""


def stated(table: pd.DataFrame) -> dict[str, dict[str, dict[str, float]]]:
    """Return the published errors: ``{set: {method: {poses, mean_mm, std_mm, max_mm}}}``.

    Args:
        table: published_measured.csv.
    """
    found: dict[str, dict[str, dict[str, float]]] = {}
    for row in table.to_dict("records"):
        errors = {f"{key}_mm": row[f"position_{key}_mm"] for key in ("mean", "std", "max")}
        found.setdefault(row["set"], {})[row["method"]] = {"poses": row["poses"], **errors}
    return found


def beside(sets: Mapping[str, Any], table: pd.DataFrame) -> dict[str, Any]:
    """Return what the paper quotes beside the errors themselves.

    Returns:
        ``stated``: the published errors; ``campaigns``: number of compared campaigns; ``ahead`` and ``behind``: those in which the mean error of the
        diagnosis on unseen poses is smaller, or greater, than that of the authors by a factor of more than ``WORSE``; ``behind_by``: the least and
        the greatest of these factors where it is greater; ``recomputed``: campaigns with errors by the authors' parameters; ``within_fit_behind``:
        those of them in which its greatest error on the poses of the fit is greater.

    Args:
        sets: ``sets`` of the summary that benchmarks/diagnosis/published.py writes.
        table: published_measured.csv.
    """
    published = stated(table)
    pairs = [
        (
            found["unseen"]["diagnosis"]["mean_mm"],
            (found["unseen"].get("theirs") or published[name][BEST])["mean_mm"],
        )
        for name, found in sets.items()
    ]
    fits = [found["fit"] for found in sets.values() if "theirs" in found.get("fit", {})]
    behind = [ours / theirs for ours, theirs in pairs if ours > WORSE * theirs]
    return {
        "stated": {name: errors for name, errors in published.items() if name in sets},
        "campaigns": len(pairs),
        "ahead": sum(WORSE * ours < theirs for ours, theirs in pairs),
        "behind": len(behind),
        "behind_by": {"least": min(behind, default=None), "greatest": max(behind, default=None)},
        "recomputed": len(fits),
        "within_fit_behind": sum(fit["diagnosis"]["max_mm"] > fit["theirs"]["max_mm"] for fit in fits),
    }
