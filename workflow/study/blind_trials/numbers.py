"""Compute the tables of the blind trials, and the numbers that the paper quotes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from study.blind_trials import benefit, summaries
from study.blind_trials.cases import Study
from study.blind_trials.score import NOISES, OUTCOMES, findings, judged
from study.blind_trials.summaries import NATURAL, Frame, of_kind, share
from study.common.provenance import code_version

FORMAT = "scalar-blind-trials/1"
UNOBSERVABLE = ("range_scale",)
"""Cases whose effect leaves no residual at any poses; they are left out of the rates of right names."""


def summarise(sets: Frame, study: Study) -> tuple[dict[str, Any], dict[str, Frame]]:
    """Return the content of ``numbers.json``, and ``{name: table}``.

    Args:
        sets: The rows of all sets, as ``run.run_sets`` returns them.
        study: The blind trials that were run.
    """
    every, found = judged(sets), findings(sets)
    tables = {
        "confusion": summaries.confusion(every),
        "power": summaries.power(every, study),
        "thresholds": summaries.thresholds(every, study),
        "by_workcell": summaries.by_workcell(every),
        "by_scene": summaries.by_scene(every),
        "nulls": summaries.nulls(every),
        "pairs": summaries.pairs(every),
        "unknown": summaries.unknown(every),
        "errors": benefit.position_errors(every),
        "reliability": benefit.reliability(found),
        "unobservable": benefit.unobservable(every),
        "wrong_answers": benefit.wrong_answers(every),
    }
    return numbers(every, found, tables, study, code_version()), tables


def numbers(
    every: Frame,
    found: Frame,
    tables: Mapping[str, Frame],
    study: Study,
    code: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the content of ``numbers.json``; units are in the names.

    Args:
        every: All sets, as ``score.judged`` returns them.
        found: All findings, as ``score.findings`` returns them.
        tables: Contains the table ``nulls``, as ``summaries.nulls`` returns it.
        study: The blind trials that were run.
        code: Version of the code, as ``provenance.code_version`` returns it.
    """
    single, pairs, unknown, null = (of_kind(every, kind) for kind in ("single", "pair", "unknown", "null"))
    return {
        "format": FORMAT,
        "code": dict(code),
        "seeds": {case.name: _seeds(every, case.name) for case in study.cases.values()},
        "workcells": list(study.workcells),
        "sets": _sets(every, study),
        "natural_size": _natural_size(single[single["size"] == NATURAL]),
        "all_sizes": {"sets": len(single), "outcomes": _outcomes(single)},
        "false_alarms": share(null["alarm"]),
        "pairs": _pairs(pairs),
        "unknown": _unknown(unknown[unknown["size"] == NATURAL]),
        **_errors(every[(every["outcome"] == "right") & (every["kind"] == "single")]),
        "named_effects": _named_effects(found[found["name"] != "unattributed"]),
        "nulls": tables["nulls"].to_dict("records"),
    }


def _sets(every: Frame, study: Study) -> dict[str, int]:
    """Return how many sets were planned, and what became of them."""
    return {
        "planned": sum(len(list(study.sets(*job))) for job in study.jobs()),
        "run": len(every),
        "not_simulated": int((every["status"] == "not_simulated").sum()),
        "failed": int((~every["status"].isin(["diagnosed", "not_simulated"])).sum()),
        "crashed": int((every["status"] == "crashed").sum()),
    }


def _outcomes(sets: Frame) -> dict[str, int]:
    """Return the number of sets with each outcome."""
    return {outcome: int((sets["outcome"] == outcome).sum()) for outcome in OUTCOMES}


def _natural_size(natural: Frame) -> dict[str, Any]:
    """Return the rates of right names, from the sets with one effect of natural size."""
    observable = natural[~natural["case"].isin(UNOBSERVABLE)]
    systematic = observable[~observable["case"].isin(NOISES)]
    return {
        "right": share(observable["outcome"] == "right"),
        "right_shifts_only": share(systematic["outcome"] == "right"),
        "outcomes": _outcomes(observable),
        "right_or_listed": share(observable["outcome"].isin(["right", "listed"])),
        "wrong_and_nothing_listed": int(observable["outcome"].isin(["wrong", "elsewhere"]).sum()),
        "right_by_case": {
            str(case): share(group["outcome"] == "right")
            for case, group in natural.groupby("case", sort=False)
        },
    }


def _pairs(pairs: Frame) -> dict[str, Any]:
    """Return how often the effects of sets with two were named."""
    return {
        "both_named": share(pairs["matched"] == 2),
        "one_named": int((pairs["matched"] == 1).sum()),
        "none_named": int((pairs["matched"] == 0).sum()),
        "with_more": int((pairs["extra"] > 0).sum()),
    }


def _unknown(unmodelled: Frame) -> dict[str, Any]:
    """Return what was said of sets with a cause that no effect models, of natural size."""
    return {
        "unattributed": share(unmodelled["verdict"] == "unattributed"),
        "given_a_wrong_name": share(unmodelled["alarm"] & (unmodelled["verdict"] != "unattributed")),
        "a_name_among_the_answers": share(unmodelled["alarm"]),
        "nothing_found": int((unmodelled["named"] == "none").sum()),
    }


def _errors(right: Frame) -> dict[str, Any]:
    """Return the ratios of the errors before and after the diagnosis and of the matched control, from the sets whose only effect was named."""
    shifts = right[~right["case"].isin(NOISES)]
    natural = shifts[shifts["size"] == NATURAL]
    return {
        "after_over_control": {
            "median_named": _ratio(right, 0.5),
            "median_named_shifts": _ratio(shifts, 0.5),
            "p95_named_shifts": _ratio(shifts, 0.95),
            "median_natural_size": _ratio(natural, 0.5),
        },
        "before_over_after": {"median_natural_size": _gain(natural)},
    }


def _named_effects(names: Frame) -> dict[str, Any]:
    """Return how many of the names that were given are right, and of those with and without alternatives."""
    return {
        "answers": share(names["right"]),
        "alone": share(names["right"][names["alternatives"] == 0]),
        "with_alternatives": share(names["right"][names["alternatives"] > 0]),
    }


def _seeds(sets: Frame, case: str) -> list[int]:
    """Return the smallest and the largest seed of a case; an empty list without sets."""
    seeds = sets["seed"][sets["case"] == case]
    return [int(seeds.min()), int(seeds.max())] if len(seeds) else []


def _ratio(sets: Frame, q: float) -> float | None:
    """Return a quantile over sets of the error after the diagnosis divided by that of the matched control; None without any ratio."""
    ratio = (sets["position_after_mm"] / sets["position_control_mm"]).to_numpy(dtype=float)
    return float(np.nanquantile(ratio, q)) if np.isfinite(ratio).any() else None


def _gain(sets: Frame) -> float | None:
    """Return the median over sets of the error before the diagnosis divided by that after it; None without any ratio."""
    gain = (sets["position_before_mm"] / sets["position_after_mm"]).to_numpy(dtype=float)
    return float(np.nanmedian(gain)) if np.isfinite(gain).any() else None
