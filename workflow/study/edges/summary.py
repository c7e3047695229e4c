"""For each degree of what is wrong, over many seeds: how accurate, how often right, how often refused."""

from __future__ import annotations

from typing import Any

import pandas as pd

from study.edges.axes import AXES

ANSWERS = ("right", "wrong", "refused", "crashed")
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
    """
    numbers: dict[str, Any] = {}
    tables: Any = summary.groupby("axis", sort=False)
    for axis, table in tables:
        sound = AXES[str(axis)].sound
        at_sound = table.loc[table["value"] == sound]
        limit = 2.0 * float(at_sound["position_worst_mm"].iloc[0]) if len(at_sound) else float("nan")
        sides = {
            "above": table[table["value"] >= sound].sort_values("value"),
            "below": table[table["value"] <= sound].sort_values("value", ascending=False),
        }
        numbers[str(axis)] = {
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


def _last(part: Any, good: Any) -> float | None:
    """Return the last value before the first that is not good."""
    run = good.to_numpy(dtype=bool).cumprod().astype(bool)
    return float(part["value"].to_numpy()[run][-1]) if run.any() else None


def _first(part: Any, so: Any) -> float | None:
    values = part["value"].to_numpy()[so.to_numpy(dtype=bool)]
    return float(values[0]) if len(values) else None
