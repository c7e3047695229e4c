"""The answers of trials: one row for each answer of each set, with what speaks for it, and whether it is right.

The sets are halved: by their numbers, and sets of an unknown cause or shape by its kind, so that no half has seen the other's causes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from scalar.diagnosis.confidence import features
from scalar.diagnosis.grounds import COMPONENT, EFFECT, STRUCTURE, FinalResiduals, Grounds
from scalar.diagnosis.repeated_changes import repetitions
from study.blind_trials.score import NOISES, UNATTRIBUTED, same
from study.blind_trials.trial_score import acceptable, flaws
from study.blind_trials.trial_summaries import truth_in
from study.tracked_trials.score import is_cause, is_true_jitter

HALVES = ("first", "second")


def answers_of(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each answer of stratified blind trials: its half, kind, name, whether it is right, and the features of its grounds."""
    rows = []
    for row in sets.to_dict("records"):
        truth, found = truth_in(row), json.loads(row["found"])
        rows += [
            answer | {"row": row["row"], "right": is_right(entry, truth, found)}
            for entry, answer in _answers_of_set(row, half_of(row, truth), found)
        ]
    return pd.DataFrame(rows)


def tracked_answers_of(sets: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each answer of tracked trials, with the columns of ``answers_of``; the column ``row`` is the kind of sensor."""
    rows = []
    for row in sets.to_dict("records"):
        causes, found = json.loads(row["injected"]), json.loads(row["found"])
        repeats = float(row["repeatability_rad"]) == 0
        rows += [
            answer | {"row": row["sensor"], "right": is_right_of_tracked(entry, causes, repeats, found)}
            for entry, answer in _answers_of_set(row, HALVES[int(row["number"]) % 2], found)
        ]
    return pd.DataFrame(rows)


def _answers_of_set(
    row: Mapping[Any, Any], half: str, found: Sequence[Mapping[str, Any]]
) -> Iterator[tuple[Mapping[str, Any], dict[str, Any]]]:
    """Yield each entry of a diagnosis that gives an answer, with the columns of the answer that do not depend on the truth."""
    given = list(every_answer(found))
    repeated = repetitions([(entry["name"], entry["target"]) for entry in given])
    for entry, n_times in zip(given, repeated, strict=True):
        kind = kind_of(entry)
        yield (
            entry,
            {"number": row["number"], "seed": row["seed"], "half": half, "poses": row["poses"]}
            | {"kind": kind, "name": entry["name"], "repeated": n_times}
            | features(grounds_from(kind, entry["grounds"])),
        )


def every_answer(found: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    """Yield the entries of a diagnosis, and instead of one that only gathers doubtful names, each of these names."""
    for entry in found:
        names = entry.get("most_like", ())
        yield from names
        if not names or entry.get("corrected_by_flexible_term"):
            yield entry


def kind_of(entry: Mapping[str, Any]) -> str:
    """Return what an entry of a diagnosis is. A variance component that is no noise is structure."""
    if entry["name"] == UNATTRIBUTED:
        return STRUCTURE
    return COMPONENT if entry["name"] in NOISES else EFFECT


def grounds_from(kind: str, entry: Mapping[str, Any]) -> Grounds:
    """Return the grounds that diagnosis.json states."""
    final_residuals = FinalResiduals(
        **{key: entry[key] for key in ("poses", "misfit", "chance", "correlated", "scans")}
    )
    own = {key: entry[key] for key in ("log_odds", "least_log_odds", "share", "others", "beside_structure")}
    return Grounds(kind, final_residuals=final_residuals, **own)


def is_right(entry: Mapping[str, Any], truth: Mapping[str, Any], found: list[Mapping[str, Any]]) -> bool:
    """Return whether an answer is right; structure is where anything is that no other entry names."""
    if entry["name"] != UNATTRIBUTED:
        return acceptable(entry, truth)
    unnamed = [i for i in truth["injected"] if not any(same(e, i) for e in found)]
    return bool(unnamed or flaws(truth))


def is_right_of_tracked(
    entry: Mapping[str, Any],
    causes: Sequence[Mapping[str, Any]],
    repeats: bool,
    found: list[Mapping[str, Any]],
) -> bool:
    """Return whether an answer of a tracked set is right.

    Args:
        entry: The answer.
        causes: Of the set.
        repeats: Whether the joints come back exactly; a jitter of poses is then wrong.
        found: All answers of the set; structure is where a cause is that none of them names.
    """
    if entry["name"] != UNATTRIBUTED:
        return any(is_cause(entry, cause) for cause in causes) or is_true_jitter(entry, repeats)
    named = [other for other in found if other["name"] != UNATTRIBUTED]
    return any(not any(is_cause(other, cause) for other in named) for cause in causes)


def half_of(row: Mapping[Any, Any], truth: Mapping[str, Any]) -> str:
    """Return the half of a set: by the kind of an unknown cause, else by the number of the set."""
    kinds = [entry["kind"] for entry in truth["injected"] if entry["name"] == "unknown"]
    number = sum(kinds[0].encode()) if kinds else int(row["number"])
    return HALVES[number % 2]
