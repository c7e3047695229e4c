"""Summarise how answers depend on the settings: a table with a row for each setting, and the numbers that the paper quotes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.settings import documentation
from study.sensitivity.answers import NAMING
from study.sensitivity.variants import DIRECTIONS, DOUBLED, HALVED, variants
from study.sensitivity.vary import RUN, UNUSED

COLUMNS = {
    "setting": "dotted name of a threshold",
    "value": "its default",
    "unit": "of the value",
    "halved": "its value when halved",
    "doubled": "its value when doubled; a share that would exceed one goes half-way to one instead",
    "sets": "blind sets with which the setting was varied",
    "used": "sets among these in whose diagnosis the setting enters an operation",
    "run": "sets among these in which the diagnosis might come out differently, so that it was run with a changed value",
    "changed_halved": "sets in which any statement of the answer changes if the setting is halved",
    "changed_doubled": "the same with the setting doubled",
    "naming_halved": "sets among those of changed_halved in which a refusal, the verdict, a name or its target changes",
    "naming_doubled": "the same with the setting doubled",
    "kinds": "kinds of statements that changed, the most frequent first, each with its number of sets",
    "example": "an example in words: the first change of naming, or without one the first change",
    "held_out_worst": "largest relative increase of the RMS error over held-out poses",
    "unseen_worst": "largest relative increase of the mean error over poses that are not in the set",
    "guards": "if nothing changed: against what the setting guards",
    "test": "if nothing changed: the test that fails without the setting",
}
TOP = 10  # number of settings that the paper lists


def tabulate(rows: pd.DataFrame, guards: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each setting, columns ``COLUMNS``, the most influential first.

    Args:
        rows: What ``vary`` returns, for all sets.
        guards: workflow/resources/guarding_settings.csv.
    """
    documented, values = documentation(DEFAULTS), {(v.setting, v.direction): v.value for v in variants()}
    guard_of = {row["setting"]: row for row in guards.to_dict("records")}
    groups: Any = rows.groupby("setting", sort=False)
    table = []
    for name, of_setting in groups:
        if name not in documented:  # a setting that was removed since
            continue
        # A count of one cannot be halved and has one variant only, the doubled one.
        by_direction: dict[str, Any] = {d: of_setting[of_setting["direction"] == d] for d in DIRECTIONS}
        changed = {d: varied[varied["changed"] != ""] for d, varied in by_direction.items()}
        naming = {d: varied[varied["changed"].map(touches_naming)] for d, varied in changed.items()}
        changes_nothing = not any(map(len, changed.values()))
        guard = guard_of[name] if changes_nothing and name in guard_of else {"guards": "", "test": ""}
        table.append(
            {
                "setting": name,
                "value": documented[name]["value"],
                "unit": documented[name]["unit"],
                **{d: values.get((name, d)) for d in DIRECTIONS},
                "sets": of_setting["set"].nunique(),
                "used": of_setting[of_setting["how"] != UNUSED]["set"].nunique(),
                "run": of_setting[of_setting["how"] == RUN]["set"].nunique(),
                **{f"changed_{d}": len(varied) for d, varied in changed.items()},
                **{f"naming_{d}": len(varied) for d, varied in naming.items()},
                "kinds": _kinds(pd.concat(list(changed.values()))),
                "example": _example(pd.concat([*naming.values(), *changed.values()])),
                "held_out_worst": _worst(of_setting, "held_out"),
                "unseen_worst": _worst(of_setting, "unseen"),
                "guards": guard["guards"],
                "test": guard["test"],
            }
        )
    frame = pd.DataFrame(table, columns=list(COLUMNS))
    order = pd.DataFrame({"naming": shares(frame, "naming"), "changed": shares(frame, "changed")})
    return frame.loc[
        order.sort_values(["naming", "changed"], ascending=False, kind="stable").index
    ].reset_index(drop=True)


def shares(table: pd.DataFrame, what: str) -> Any:
    """Return for each setting the share of its tries (halved and doubled, on each set) that changed an answer.

    Args:
        table: As ``tabulate`` returns it.
        what: ``changed`` for any statement, ``naming`` for refusals, verdicts, names and targets alone.
    """
    return (table[f"{what}_{HALVED}"] + table[f"{what}_{DOUBLED}"]) / (2 * table["sets"])


def touches_naming(changed: str) -> bool:
    """Return whether any kind of change, of a list with ``;`` between, is one of ``NAMING``: a refusal, a verdict, a name or a target."""
    return any(kind in NAMING for kind in changed.split(";"))


def _kinds(changed: pd.DataFrame) -> str:
    """Return the kinds of changes with their numbers of sets, ``names 3; values 1``."""
    sets: dict[str, set[str]] = {}
    for row in changed.to_dict("records"):
        for kind in row["changed"].split(";"):
            sets.setdefault(kind, set()).add(row["set"])
    return "; ".join(f"{kind} {len(sets[kind])}" for kind in sorted(sets, key=lambda kind: -len(sets[kind])))


def _example(changed: pd.DataFrame) -> str:
    """Return the first change in words; an empty text without one."""
    if not len(changed):
        return ""
    row = changed.iloc[0]
    return f"{row['set']}, {row['direction']}: {row['example']}"


def _worst(rows: pd.DataFrame, what: str) -> float:
    """Return the largest relative increase of an error, ``held_out`` or ``unseen``, over all variants with an answer."""
    before, after = (rows[f"{what}{suffix}_mm"].to_numpy(dtype=float) for suffix in ("_default", ""))
    both = np.isfinite(before) & np.isfinite(after)
    return float(np.max(after[both] / before[both] - 1.0, initial=0.0))


def still_open(rows: pd.DataFrame) -> list[str]:
    """Return the settings to vary on more sets: those that changed an answer, and those for which no variant had to be run."""
    groups: Any = rows.groupby("setting", sort=False)
    return [
        name
        for name, of_setting in groups
        if (of_setting["changed"] != "").any() or not (of_setting["how"] == RUN).any()
    ]


def numbers(table: pd.DataFrame, rows: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers that the paper quotes.

    Args:
        table: As ``tabulate`` returns it.
        rows: The rows from which the table was made.
    """
    changed, naming = shares(table, "changed") > 0, shares(table, "naming") > 0
    top: Any = table[changed].head(TOP)
    guarded: Any = table["test"] != ""
    used: Any = table["used"] > 0
    run: Any = table["run"] > 0
    return {
        "commits": sorted(set(rows["commit"].dropna())),
        "sets": {"all": len(set(rows["set"])), "fewest": min(table["sets"].tolist())},
        "settings": {
            "all": len(table),
            "used": int(used.sum()),
            "run": int(run.sum()),
            "changed": int(changed.sum()),
            "naming": int(naming.sum()),
            "silent": int((~changed).sum()),
            "guarding": int((guarded & ~changed).sum()),
        },
        "naming": dict(zip(table["setting"], shares(table, "naming").tolist(), strict=True)),
        "top": [_quoted(row) for row in top.to_dict("records")],
    }


def _quoted(row: Mapping[Any, Any]) -> dict[str, Any]:
    """Return what the paper quotes of one row of the table."""
    tried = 2 * row["sets"]
    return {
        "setting": row["setting"],
        "sets": row["sets"],
        "naming": (row["naming_halved"] + row["naming_doubled"]) / tried,
        "changed": (row["changed_halved"] + row["changed_doubled"]) / tried,
        "unseen_worst": row["unseen_worst"],
    }
