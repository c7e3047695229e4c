"""For each degree of what is wrong, over many seeds: how accurate, how often right, how often refused."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from study.edges.axes import AXES

ANSWERS = ("right", "unattributed", "wrong", "refused", "crashed")
"""``unattributed``: a gear was injected, and structure is reported whose cause is not named in full. The others as ``EDGE_COLUMNS`` has them."""
SUMMARY_COLUMNS = {
    "axis": "what is wrong",
    "value": "how much of it",
    "sets": "number",
    **{answer: "share of the sets" for answer in ANSWERS},
    "position_median_mm": "median over the sets that were not refused of the mean position error",
    "position_worst_mm": "the largest of them",
}


def summarise_edges(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each axis and value, columns ``SUMMARY_COLUMNS``, in the order of the axes."""
    found = []
    not_named = (
        (rows["answer"] == "wrong") & (rows["verdict"] == "unattributed") & (rows["injected"] != "nothing")
    )
    rows = rows.assign(answer=rows["answer"].mask(not_named, "unattributed"))
    groups: Any = rows.groupby(["axis", "value"], sort=True)
    for (axis, value), sets in groups:
        position = sets["position_after_mm"].dropna()
        found.append(
            {
                "axis": axis,
                "value": value,
                "sets": len(sets),
                **{name: float((sets["answer"] == name).mean()) for name in ANSWERS},
                "position_median_mm": position.median() if len(position) else None,
                "position_worst_mm": position.max() if len(position) else None,
            }
        )
    order = {axis: k for k, axis in enumerate(AXES)}
    table = pd.DataFrame(found, columns=list(SUMMARY_COLUMNS))
    by_axis: Any = lambda column: column.map(order) if column.name == "axis" else column  # noqa: E731
    return table.sort_values(["axis", "value"], key=by_axis)


def edge_numbers(summary: pd.DataFrame) -> dict[str, Any]:
    """Return for each axis the last value, going away from where nothing is wrong, up to which all sets have an error of at most twice
    that of sound data, and up to which all answers are right; None where this fails for sound data already.

    Beside the sides of an axis stand the numbers of each value (``at``; the point of a value is written as ``_``), and beside the axes the number of
    sets of a value, and the largest error of the sound ones.
    """
    first = summary.iloc[0]
    numbers: dict[str, Any] = {"sets": int(first["sets"])}
    tables: Any = summary.groupby("axis", sort=False)
    for axis, table in tables:
        sound = AXES[str(axis)].sound
        at_sound = table.loc[table["value"] == sound]
        worst = float(at_sound["position_worst_mm"].iloc[0]) if len(at_sound) else float("nan")
        limit = 2.0 * worst
        sides = {
            "above": table[table["value"] >= sound].sort_values("value"),
            "below": table[table["value"] <= sound].sort_values("value", ascending=False),
        }
        numbers["sound"] = {"position_worst_mm": worst}
        numbers[str(axis)] = {"at": {_key(row["value"]): _at(row) for row in table.to_dict("records")}}
        numbers[str(axis)] |= {
            side: {
                "accurate_to": _last(part, (part["position_worst_mm"] <= limit) & (part["refused"] == 0)),
                "right_to": _last(part, part["right"] == 1.0),
                "refused_from": _first(part, part["refused"] > 0),
                "crashed": float(part["crashed"].max()),
            }
            for side, part in sides.items()
            if len(part) > 1
        }
    return numbers


def _key(value: float) -> str:
    """Return the value as a part of a number's name, which has no point: ``0_3``."""
    return f"{value:g}".replace(".", "_")


def _at(row: Mapping[str, Any]) -> dict[str, Any]:
    names = ("position_median_mm", "position_worst_mm")
    errors = {name: None if pd.isna(row[name]) else float(row[name]) for name in names}
    return {"value": float(row["value"])} | errors | {answer: float(row[answer]) for answer in ANSWERS}


def _last(part: Any, good: Any) -> float | None:
    """Return the last value before the first that is not good."""
    run = good.to_numpy(dtype=bool).cumprod().astype(bool)
    return float(part["value"].to_numpy()[run][-1]) if run.any() else None


def _first(part: Any, so: Any) -> float | None:
    values = part["value"].to_numpy()[so.to_numpy(dtype=bool)]
    return float(values[0]) if len(values) else None
