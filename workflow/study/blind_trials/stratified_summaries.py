"""The tables of the stratified blind trials: rates with intervals for each kind of set, ratios of errors, and right answers by stated confidence."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.score import same
from study.blind_trials.statistics import LEVEL, wilson
from study.blind_trials.stratified_design import FACTORS
from study.blind_trials.stratified_score import answers, trial_score
from study.common.provenance import code_version, design_identity

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
RATIOS = ("after_over_floor", "after_over_before", "after_over_told", "told_over_floor")
CONDITION_RATES = ("clean", "wrong", "wrong_sure", "worse")  # that are counted for each level of each factor
QUANTILES = (0.5, 0.95, 1.0)
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 1.0)  # edges of the bins of the stated confidence
WEAK = 5.0  # standard errors in a calibration that is told the causes: an effect with fewer is hardly distinguished from chance among all candidates
DRAWS, SEED = 1000, 20_261_122  # number of draws of the bootstrap, and their seed


def rate_table(scored: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each kind of set and rate: count, share and Wilson's 95 % interval of the share, since each set is a scene of its own."""
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
    """Return quantiles over the sets of the ratios ``RATIOS``, a row for each kind of set, ratio and quantile, with bootstrap intervals.

    Sets in which a ratio is not defined (NaN) do not count to it; a ratio that is defined in no set of a kind has no row there.
    """
    rows = []
    rng = np.random.default_rng(SEED)
    for row, group in _groups(scored):
        for ratio in RATIOS:
            values = group[ratio].to_numpy(dtype=float)
            values = values[~np.isnan(values)]
            if not len(values):
                continue
            drawn = values[rng.integers(len(values), size=(DRAWS, len(values)))]
            for q in QUANTILES:
                low, high = np.quantile(np.quantile(drawn, q, axis=1, method="higher"), [0.5 - LEVEL / 2, 0.5 + LEVEL / 2],
                                        method="nearest")  # fmt: skip
                value = float(np.quantile(values, q, method="higher"))
                rows.append(
                    {
                        "row": row,
                        "ratio": ratio,
                        "sets": len(values),
                        "quantile": q,
                        "value": value,
                        "low": low,
                        "high": high,
                    }
                )
    return pd.DataFrame(rows)


def confidence_bins(answers: pd.DataFrame) -> pd.DataFrame:
    """Return the share of right answers in bins of the stated confidence, separately for effects and variance components.

    Args:
        answers: As ``named_answers`` returns them.
    """
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
    """Return (row of the table, its sets) in the order of ``ROWS``, without empty ones, and ``all`` with all sets at the end."""
    known = [(row, scored[scored["row"] == row]) for row in ROWS]
    return [(row, group) for row, group in known if len(group)] + [("all", scored)]


def scored(sets: pd.DataFrame) -> pd.DataFrame:
    """Return the sets with the entries of ``trial_score`` as further columns; sets that could not be simulated are left out."""
    rows = []
    simulated: Any = sets[sets["status"] != "not_simulated"]
    for row in simulated.to_dict("records"):
        errors = {when: _number(row[f"position_{when}_mm"]) for when in ("before", "after", "floor", "told")}
        found, unobservable = json.loads(row["found"]), json.loads(row["unobservable"])
        score = trial_score(truth_in(row), found, unobservable, errors)
        rows.append({**row, **score, "failed": row["status"] != "diagnosed"})
    return pd.DataFrame(rows)


def named_answers(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each entry with a name in the diagnoses of all sets: the row of the table, number of poses, and entries of ``answers``."""
    rows = [
        {"row": row["row"], "poses": row["poses"]} | answer
        for row in sets.to_dict("records")
        for answer in answers(truth_in(row), json.loads(row["found"]))
    ]
    return pd.DataFrame(rows, columns=["row", "poses", "name", "of", "confidence", "right"])


def condition_counts(judged: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each level of each factor of the design: the number of sets, and in how many of them each of ``CONDITION_RATES`` holds.

    The factor ``injected`` has a level for each kind of injected effects, as ``kind_of_injected`` names it.

    Args:
        judged: As ``scored`` returns it.
    """
    table: Any = judged.assign(injected=[kind_of_injected(json.loads(text)) for text in judged["injected"]])
    rows = [
        {"factor": factor, "level": level, "sets": len(group)}
        | {rate: int(group[rate].sum()) for rate in CONDITION_RATES}
        for factor in FACTORS
        for level, group in table.groupby(factor, sort=False)
    ]
    return pd.DataFrame(rows)


def kind_of_injected(injected: Sequence[Mapping[str, Any]]) -> str:
    """Return ``none``, the number of injected effects of the catalogue, or ``unknown`` for a cause that has no name in it."""
    if any(effect["name"] == "unknown" for effect in injected):
        return "unknown"
    return str(len(injected)) if injected else "none"


def truth_in(row: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the truth of a set, as ``acceptable`` takes it, from its row."""
    return {key: json.loads(row[f"{key}_truth"]) for key in ("scanner", "surface")} | {
        "injected": json.loads(row["injected"])
    }


def named_by_significance(sets: pd.DataFrame) -> dict[str, dict[str, int]]:
    """Return how many injected effects of the catalogue are named with their place, by how significant they are to a calibration that is told all.

    Args:
        sets: The rows of all sets. Tables of earlier exams have no column ``told_significance``; their effects do not count.

    Returns:
        For effects of less than ``WEAK`` standard errors (``weak``) and for the others (``strong``): the numbers ``injected`` and ``named``.
    """
    counts = {group: {"injected": 0, "named": 0} for group in ("weak", "strong")}
    for row in sets.to_dict("records"):
        found = json.loads(row["found"])
        injected = json.loads(row["injected"])
        for effect, z in zip(injected, json.loads(row.get("told_significance", "[]")), strict=False):
            if z is not None:
                group = counts["weak" if z < WEAK else "strong"]
                group["injected"] += 1
                group["named"] += any(same(entry, effect) for entry in found)
    return counts


def set_aside_by_scanner(sets: pd.DataFrame) -> dict[str, dict[str, int]]:
    """Return for each scanner how many poses were diagnosed, and how many of them were set aside although all are good.

    Args:
        sets: The rows of all sets. Tables of earlier runs have no column ``set_aside``; the result is then empty.
    """
    every: Any = sets
    if "set_aside" not in sets:
        return {}
    diagnosed = every[(every["status"] == "diagnosed") & every["set_aside"].notna()]
    return {
        str(scanner): {"poses": int(group["poses"].sum()), "set_aside": int(group["set_aside"].sum())}
        for scanner, group in diagnosed.groupby("scanner", sort=False)
    }


def _number(value: Any) -> float | None:
    """Return a finite number as it is, and None for anything else."""
    return None if value is None or not np.isfinite(value) else float(value)


def summarise_trials(
    sets: pd.DataFrame, design: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, pd.DataFrame]]:
    """Return numbers and ``{name: table}``.

    The numbers are the version of the code, the design with its checksum, counts of sets and of good poses that were set aside, the worst ratio of
    errors, and the processor time. The tables are ``table`` (the rates), ``ratios``, ``confidence`` and ``conditions`` (counts of some rates for each
    level of each factor).

    Args:
        sets: The rows of all sets, as ``run_trials`` returns them.
        design: Content of the config from which the sets were drawn.
    """
    judged: Any = scored(sets)
    columns: Any = sets
    seconds = {key: float(columns[key].sum()) for key in ("simulate_s", "diagnose_s")}
    numbers = {
        "code": code_version(),
        "design": design_identity(design),
        "failed": int(judged["failed"].sum()),
        "worst_after_over_before": float(judged.loc[~judged["failed"], "after_over_before"].max()),
        "named_by_significance": named_by_significance(sets),
        "good_poses_set_aside": set_aside_by_scanner(sets),
        "sets": len(sets),
        "not_simulated": int((columns["status"] == "not_simulated").sum()),
        "processor_hours": sum(seconds.values()) / 3600,
        **{f"{key}_mean": value / max(len(sets), 1) for key, value in seconds.items()},
    }
    return numbers, {
        "table": rate_table(judged),
        "ratios": ratios(judged),
        "confidence": confidence_bins(named_answers(sets)),
        "conditions": condition_counts(judged),
    }
