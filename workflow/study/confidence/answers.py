"""List the answers of trials: a row for each answer of each set, with the features of its grounds, and whether it is right.

The sets are divided into two halves by their numbers; sets with an unknown cause or shape are divided by its kind, so that no such kind occurs in
both halves.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from scalar.diagnosis.naming.confidence import features
from scalar.diagnosis.naming.grounds import COMPONENT, EFFECT, STRUCTURE, FinalResiduals, Grounds
from scalar.diagnosis.naming.repeated_changes import repetitions
from study.blind_trials.score import NOISES, UNATTRIBUTED, same
from study.blind_trials.stratified_score import acceptable, flaws
from study.blind_trials.stratified_summaries import truth_in
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
    """Yield every answer of a diagnosis.

    These are its entries. An entry may list doubtful names (``most_like``): these are answers too, and the entry itself is one only if it was
    corrected by a flexible term.
    """
    for entry in found:
        names = entry.get("most_like", ())
        yield from names
        if not names or entry.get("corrected_by_flexible_term"):
            yield entry


def kind_of(entry: Mapping[str, Any]) -> str:
    """Return the kind of an answer: ``STRUCTURE`` if it is unattributed, ``COMPONENT`` if it is a variance component, else ``EFFECT``."""
    if entry["name"] == UNATTRIBUTED:
        return STRUCTURE
    return COMPONENT if entry["name"] in NOISES else EFFECT


def grounds_from(kind: str, entry: Mapping[str, Any]) -> Grounds:
    """Return the grounds of an answer of the given kind, from the entry ``grounds`` of diagnosis.json."""
    final_residuals = FinalResiduals(
        **{key: entry[key] for key in ("poses", "misfit", "chance", "correlated", "scans")}
    )
    named = ("log_odds", "least_log_odds", "share", "others", "beside_structure", "structure_there")
    own = {key: entry[key] for key in named}
    return Grounds(kind, final_residuals=final_residuals, **own)


def is_right(entry: Mapping[str, Any], truth: Mapping[str, Any], found: list[Mapping[str, Any]]) -> bool:
    """Return whether an answer is right.

    A name is right if it is acceptable (``stratified_score``). Unattributed structure is right if something was injected that no entry names, or if
    the scanner or a surface has systematic errors.

    Args:
        entry: The answer.
        truth: The truth of the set, as ``truth_in`` returns it.
        found: All entries of the diagnosis.
    """
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
        causes: The injected causes of the set.
        repeats: Whether the joints return exactly to a pose; a jitter of poses is then wrong.
        found: All entries of the diagnosis. Unattributed structure is right if none of them names some cause.
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
