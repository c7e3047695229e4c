"""Summarise over the seeds, for each kind and degree of a fault, how accurate, how often right and how often refused the diagnosis is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from study.edges.axes import AXES

ANSWERS = ("right", "unattributed", "wrong", "refused", "crashed")
"""As in ``EDGE_COLUMNS``, and ``unattributed``: a gear error was injected, and the verdict is that there is structure without a full name."""
SUMMARY_COLUMNS = {
    "axis": "kind of fault",
    "value": "its degree, in the unit of the axis",
    "sets": "number of sets",
    **{answer: "share of the sets" for answer in ANSWERS},
    "position_median_mm": "median over the sets with a calibration of the mean position error",
    "position_worst_mm": "the largest of these mean position errors",
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
    """Return the numbers that the paper quotes: how far a fault may go until the diagnosis is inaccurate, wrong or refuses.

    Returns:
        ``sets``, the number of sets of a value; ``sound``, the largest error without a fault; and for each axis its numbers at each value (``at``;
        the point of a value is written as ``_``) and on each side of the value without a fault (``above``, ``below``). There, ``accurate_to`` is
        the last value up to which no set is refused and every error is at most twice the largest one without a fault, and ``right_to`` the last
        value up to which all answers are right; None if this fails even without a fault.
    """
    first = summary.iloc[0]
    numbers: dict[str, Any] = {"sets": int(first["sets"])}
    tables: Any = summary.groupby("axis", sort=False)
    for axis, table in tables:
        scene_value = AXES[str(axis)].scene_value
        without_fault = table.loc[table["value"] == scene_value]
        worst = float(without_fault["position_worst_mm"].iloc[0]) if len(without_fault) else float("nan")
        limit = 2.0 * worst
        sides = {
            "above": table[table["value"] >= scene_value].sort_values("value"),
            "below": table[table["value"] <= scene_value].sort_values("value", ascending=False),
        }
        numbers["sound"] = {"position_worst_mm": worst}
        numbers[str(axis)] = {"at": {_key(row["value"]): _at(row) for row in table.to_dict("records")}}
        numbers[str(axis)] |= {
            side: {
                "accurate_to": _last(rows, (rows["position_worst_mm"] <= limit) & (rows["refused"] == 0)),
                "right_to": _last(rows, rows["right"] == 1.0),
                "refused_from": _first(rows, rows["refused"] > 0),
                "crashed": float(rows["crashed"].max()),
            }
            for side, rows in sides.items()
            if len(rows) > 1
        }
    return numbers


def _key(value: float) -> str:
    """Return the value as a part of a number's name, which has no point: ``0_3``."""
    return f"{value:g}".replace(".", "_")


def _at(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers at one value of an axis."""
    names = ("position_median_mm", "position_worst_mm")
    errors = {name: None if pd.isna(row[name]) else float(row[name]) for name in names}
    return {"value": float(row["value"])} | errors | {answer: float(row[answer]) for answer in ANSWERS}


def _last(rows: Any, good: Any) -> float | None:
    """Return the last value before the first one at which ``good`` is False; None if that is the first of all."""
    good_so_far = good.to_numpy(dtype=bool).cumprod().astype(bool)
    return float(rows["value"].to_numpy()[good_so_far][-1]) if good_so_far.any() else None


def _first(rows: Any, holds: Any) -> float | None:
    """Return the first value at which ``holds`` is True; None without one."""
    values = rows["value"].to_numpy()[holds.to_numpy(dtype=bool)]
    return float(values[0]) if len(values) else None
