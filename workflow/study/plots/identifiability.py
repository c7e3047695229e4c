"""The singular values of the Jacobian: how many directions are unobservable, and how clear the gap is."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import new_figure, styled

_FLOOR = 1e-19  # a singular value that is exactly zero is drawn here


def draw_singular_values(values: pd.DataFrame, directions: pd.DataFrame) -> Figure:
    """Return the singular values from the largest on, those that count as zero hollow, and what is fixed.

    Args:
        values: singular_values.csv. directions: null_directions.csv.
    """
    with styled():
        figure = new_figure(7.4, 3.8)
        ax = figure.subplots()
        height = values["singular_value"].clip(lower=_FLOOR)
        null = values["null"].to_numpy(dtype=bool)
        ax.plot(
            values["index"][~null],
            height[~null],
            "o",
            color="#0072b2",
            markersize=5,
            label=f"{(~null).sum()} identified directions",
        )
        ax.plot(
            values["index"][null],
            height[null],
            "s",
            markerfacecolor="white",
            markeredgecolor="#d55e00",
            markeredgewidth=1.4,
            markersize=6,
            label=f"{null.sum()} counted as zero",
        )
        ax.axhline(
            values["tolerance"].iloc[0],
            color="black",
            linestyle="--",
            linewidth=1,
            label="limit: below it a value counts as zero",
        )
        ax.set_yscale("log")
        ax.set_ylim(_FLOOR, 3)
        ax.set_xlim(0, len(values) + 1)
        ax.set_xlabel(f"index among the {len(values)} columns")
        ax.set_ylabel("singular value / largest (columns of unit length)")
        if len(directions):
            held = ", ".join(directions["held"])
            ax.set_title(f"fixed because of them: {held}", fontsize=9)
        ax.legend(loc="lower left")
    return figure
