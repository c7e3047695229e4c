"""Count in tables of results what the paper quotes: sets, right answers, correlations, pairs of causes, sets of a kind, exams."""

from __future__ import annotations

import json
from collections.abc import Iterable
from itertools import combinations
from typing import Any

import pandas as pd

from scalar.planning.separation import ANSWERED
from study.blind_trials.score import SURE

STRONG = 0.7
"""Least absolute value of a correlation that has a key of its own."""
MOMENTS = ("plane_moved", "sensor_slip")
"""Effects that begin at a moment, for which the lasso and stability selection have no columns."""

UNNAMED = ("unknown cause", "shape also tried")
"""Rows of the stratified design whose cause has no name in the catalogue."""

RUN_BEFORE = 25
"""The first sets of the comparison with rivals, which an earlier version of the diagnosis had been run on; no version had seen the others."""


def conditions(table: pd.DataFrame) -> dict[str, dict[str, dict[str, int]]]:
    """Return ``{factor: {level: {sets, clean, wrong, wrong_sure, worse}}}``.

    Args:
        table: conditions.csv of the stratified trials.
    """
    found: dict[str, dict[str, dict[str, int]]] = {}
    for row in table.to_dict("records"):
        counts = {str(key): int(value) for key, value in row.items() if str(key) not in ("factor", "level")}
        found.setdefault(str(row["factor"]), {})[str(row["level"])] = counts
    return found


def confidence(table: pd.DataFrame) -> dict[str, dict[str, Any]]:
    """Return, for effects and variance components, how many answers have a confidence of ``SURE`` or more, or less, and how many are right.

    Args:
        table: confidence.csv of the stratified trials.

    Returns:
        ``{of: {sure, sure_and_wrong, unsure, unsure_and_right, unsure_stated}}``; the last is the mean confidence of the answers that are not sure.
    """
    found: dict[str, dict[str, Any]] = {}
    for of, rows in table.groupby("of", sort=False):
        every: Any = rows
        sure, unsure = every[every["from"] >= SURE], every[every["from"] < SURE]
        n = int(unsure["answers"].sum())
        stated = float((unsure["answers"] * unsure["mean_stated"].fillna(0.0)).sum())
        found[str(of)] = {
            "sure": int(sure["answers"].sum()),
            "sure_and_wrong": int((sure["answers"] - sure["right"]).sum()),
            "unsure": n,
            "unsure_and_right": int(unsure["right"].sum()),
            "unsure_stated": stated / n if n else None,
        }
    return found


def larger_as_printed(values: Iterable[float], than: float, digits: int) -> int:
    """Return how many numbers are larger than another one, all rounded to so many significant digits as the paper prints them."""
    return sum(float(f"{value:.{digits - 1}e}") > float(f"{than:.{digits - 1}e}") for value in values)


def separated(table: pd.DataFrame) -> dict[str, int]:
    """Return for how many pairs that the planned poses may separate the injected effect is then named alone, and counts of all pairs.

    Args:
        table: separation.csv of the planned poses. Pairs that the diagnosed poses should separate already do not count as pairs that the planned
            poses may separate.

    Returns:
        ``pairs``, ``named_alone``, ``named_alone_at_random``; ``open`` and ``already``, the numbers of pairs that the diagnosed poses should not and
        should separate; of all pairs ``of_all_planned`` and ``of_all_at_random``, how many the new diagnosis distinguishes, and ``neither``, how many
        have two causes that were not injected.
    """
    every, still_open = _confounded(table)
    pairs = every[every["separable"].eq(True) & still_open]
    return {
        "pairs": len(pairs),
        "named_alone": int(pairs["right_then"].eq(True).sum()),
        "named_alone_at_random": int(pairs["right_then_at_random"].eq(True).sum()),
        "open": int(still_open.sum()),
        "already": int((~still_open).sum()),
        "of_all_planned": int(every["distinguished"].eq(True).sum()),
        "of_all_at_random": int(every["distinguished_at_random"].eq(True).sum()),
        "neither": int(every["right"].eq("neither").sum()),
    }


def _confounded(table: pd.DataFrame) -> tuple[Any, Any]:
    """Return the rows of separation.csv with a confounded pair, and for each whether the diagnosed poses leave it open."""
    whole: Any = table
    every = whole[whole["pairs"] > 0]
    return every, every["now"] < ANSWERED**0.5


def over_workspace(table: pd.DataFrame) -> dict[str, float]:
    """Return the number of places of the scanner as seen from the side, and the least and greatest root mean square error [mm] in one of them.

    Args:
        table: workspace.csv of the headline.
    """
    side: Any = table[table["view"] == "side"]
    return {
        "places": len(side),
        "after_least_mm": float(side["after_mm"].min()),
        "after_greatest_mm": float(side["after_mm"].max()),
    }


def confounded_pairs(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return which pairs of causes the diagnosis confounds, and how many of each some further poses can separate; those that most can come first.

    Args:
        table: separation.csv of the planned poses.

    Returns:
        For each pair ``first`` and ``second``, the titles of the two causes in the order of the alphabet; ``pairs``, how many sets confound them;
        ``by_some`` and ``by_all``, in how many of these some choice of as many poses, and all poses of the pool together, can separate them (pairs
        that the diagnosed poses separate already do not count); ``planned`` and ``at_random``, in how many the new diagnosis distinguishes them.
    """
    every, still_open = _confounded(table)
    causes = [tuple(sorted(pair)) for pair in zip(every["effect"], every["rival"], strict=True)]
    counted: Any = pd.DataFrame(
        {
            "causes": causes,
            "pairs": 1,
            "by_some": (every["separable"].eq(True) & still_open).astype(int).to_numpy(),
            "by_all": (every["separable_by_all"].eq(True) & still_open).astype(int).to_numpy(),
            "planned": every["distinguished"].eq(True).astype(int).to_numpy(),
            "at_random": every["distinguished_at_random"].eq(True).astype(int).to_numpy(),
        }
    )
    sums = counted.groupby("causes").sum().sort_values(["by_some", "by_all", "pairs"], ascending=False)
    return [
        {"first": first, "second": second} | {str(key): int(count) for key, count in row.items()}
        for (first, second), row in sums.to_dict("index").items()
    ]


def strong_correlations(table: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return ``{parameter: {later parameter: absolute value}}`` of all correlations of at least ``STRONG``.

    Args:
        table: correlation.csv of the headline, a square with the parameters' names in its first column.
    """
    square: Any = table.set_index("parameter").abs()
    found: dict[str, dict[str, float]] = {}
    for a, b in combinations(square.index, 2):
        if square.loc[a, b] >= STRONG:
            found.setdefault(str(a), {})[str(b)] = float(square.loc[a, b])
    return found


def with_moment(table: pd.DataFrame) -> int:
    """Return in how many sets of the comparison with rivals one of the effects ``MOMENTS`` was injected.

    Args:
        table: Rows of sets and contestants, with columns ``number`` and ``injected``.
    """
    sets: Any = table.drop_duplicates("number")
    return sum(any(effect["name"] in MOMENTS for effect in json.loads(text)) for text in sets["injected"])


def by_names(table: pd.DataFrame) -> dict[str, dict[str, int]]:
    """Return how many sets of the comparison with rivals have causes without a name, and only named ones, and how many each contestant answers.

    A cause without a name is answered without a fault by a report of unmodelled structure, which only the diagnosis can make.

    Args:
        table: Rows of sets and contestants, with columns ``number``, ``row``, ``contestant`` and ``clean``.

    Returns:
        For ``unnamed`` and ``named`` causes ``sets``, the number of clean answers of each contestant that gives names, and ``only_diagnosis`` and
        ``only_stepwise``, how many of the two the diagnosis or stepwise selection alone answers.
    """
    every: Any = table[table["clean"].notna()]
    square = every.pivot(index="number", columns="contestant", values="clean").astype(bool)
    unnamed = every.groupby("number")["row"].first().isin(UNNAMED)
    found = {}
    for name, part in (("unnamed", square[unnamed]), ("named", square[~unnamed])):
        diagnosis, stepwise = part["diagnosis"], part["stepwise"]
        found[name] = {
            "sets": len(part),
            **{str(contestant): int(part[contestant].sum()) for contestant in part},
            "only_diagnosis": int((diagnosis & ~stepwise).sum()),
            "only_stepwise": int((stepwise & ~diagnosis).sum()),
        }
    return found


def not_run_before(table: pd.DataFrame) -> dict[str, int]:
    """Return how many sets of the comparison with rivals no version had seen, and how many of these each contestant answers without a fault.

    Args:
        table: Rows of sets and contestants, with columns ``number``, ``contestant`` and ``clean``.

    Returns:
        ``sets``, and a number for each contestant that gives names.
    """
    fresh: Any = table[(table["number"] >= RUN_BEFORE) & table["clean"].notna()]
    counts: Any = fresh.groupby("contestant")["clean"]
    return {"sets": int(fresh["number"].nunique())} | {
        str(name): int(clean.astype(bool).sum()) for name, clean in counts
    }
