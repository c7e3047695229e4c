"""How answers depend on each setting: a table with a row for each, and the numbers that the paper quotes."""

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
    "sets": "blind sets on which both were tried",
    "used": "of them, those whose diagnosis puts the setting to use",
    "run": "of them, those in which the path of the diagnosis might differ, so that it was run",
    "changed_halved": "sets in which any statement of the answer is another with the setting halved",
    "changed_doubled": "the same, doubled",
    "naming_halved": "of them, sets in which what is refused, the verdict, a name or its target is another",
    "naming_doubled": "the same, doubled",
    "kinds": "kinds of statements that changed, the most frequent first, each with its number of sets",
    "example": "the gravest change, in words",
    "held_out_worst": "largest relative increase of the rms over poses held out",
    "unseen_worst": "largest relative increase of the mean error over true poses",
    "guards": "where nothing changed: against what the setting guards",
    "test": "where nothing changed: the test in which it decides",
}
TOP = 10


def tabulate(rows: pd.DataFrame, guards: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each setting, columns ``COLUMNS``, the most influential first.

    Args:
        rows: Of all sets, as ``vary`` gives them. guards: workflow/resources/guarding_settings.csv.
    """
    documented, values = documentation(DEFAULTS), {(v.setting, v.direction): v.value for v in variants()}
    known = {row["setting"]: row for row in guards.to_dict("records")}
    groups: Any = rows.groupby("setting", sort=False)
    table = []
    for name, of_setting in groups:
        if name not in documented:  # a setting that was removed since
            continue
        # A count of one cannot be halved and has one variant only, the doubled one.
        by_direction: dict[str, Any] = {d: of_setting[of_setting["direction"] == d] for d in DIRECTIONS}
        changed = {d: part[part["changed"] != ""] for d, part in by_direction.items()}
        naming = {d: part[part["changed"].map(touches_naming)] for d, part in changed.items()}
        changes_nothing = not any(map(len, changed.values()))
        guard = known[name] if changes_nothing and name in known else {"guards": "", "test": ""}
        table.append(
            {
                "setting": name,
                "value": documented[name]["value"],
                "unit": documented[name]["unit"],
                **{d: values.get((name, d)) for d in DIRECTIONS},
                "sets": of_setting["set"].nunique(),
                "used": of_setting[of_setting["how"] != UNUSED]["set"].nunique(),
                "run": of_setting[of_setting["how"] == RUN]["set"].nunique(),
                **{f"changed_{d}": len(part) for d, part in changed.items()},
                **{f"naming_{d}": len(part) for d, part in naming.items()},
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
    """Return for each setting the share of variants, halved and doubled, that changed something: ``changed`` or ``naming``."""
    return (table[f"{what}_{HALVED}"] + table[f"{what}_{DOUBLED}"]) / (2 * table["sets"])


def touches_naming(changed: str) -> bool:
    """Return whether any of the kinds of changes is one of what is named."""
    return any(kind in NAMING for kind in changed.split(";"))


def _kinds(changed: pd.DataFrame) -> str:
    sets: dict[str, set[str]] = {}
    for row in changed.to_dict("records"):
        for kind in row["changed"].split(";"):
            sets.setdefault(kind, set()).add(row["set"])
    return "; ".join(f"{kind} {len(sets[kind])}" for kind in sorted(sets, key=lambda kind: -len(sets[kind])))


def _example(changed: pd.DataFrame) -> str:
    if not len(changed):
        return ""
    row = changed.iloc[0]
    return f"{row['set']}, {row['direction']}: {row['example']}"


def _worst(rows: pd.DataFrame, what: str) -> float:
    """Return the largest relative increase of an error over all variants that were answered."""
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
    """Return what the paper quotes.

    Args:
        table: As ``tabulate`` gives it. rows: What it was made from.
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
    tried = 2 * row["sets"]
    return {
        "setting": row["setting"],
        "sets": row["sets"],
        "naming": (row["naming_halved"] + row["naming_doubled"]) / tried,
        "changed": (row["changed_halved"] + row["changed_doubled"]) / tried,
        "unseen_worst": row["unseen_worst"],
    }
