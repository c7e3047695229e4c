"""The figure of the singular values of the Jacobian: how many directions are unobservable, and the gap between these and the others."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import COLUMN_IN, LINE, PROPOSED, new_figure, styled, symbol

_WIDTH_IN = 1.3 * COLUMN_IN  # drawn 1.3 columns wide and scaled to one, so 8 pt text prints at 6.2 pt
_FLOOR = 1e-19  # a singular value that is exactly zero is drawn here


def draw_singular_values(values: pd.DataFrame, directions: pd.DataFrame) -> Figure:
    """Return a plot of the singular values in descending order (hollow markers: counted as zero); the title names the parameters fixed.

    Args:
        values: singular_values.csv: ``index, singular_value, null, tolerance``, of the Jacobian with columns of unit length, the
            largest value scaled to 1.
        directions: null_directions.csv; its column ``held`` names the parameter fixed for each null direction.
    """
    with styled():
        figure = new_figure(_WIDTH_IN, 3.0)
        ax = figure.subplots()
        height = values["singular_value"].clip(lower=_FLOOR)
        null = values["null"].to_numpy(dtype=bool)
        ax.plot(
            values["index"][~null],
            height[~null],
            "o",
            color=PROPOSED,
            markersize=5,
            label=f"{(~null).sum()} identified directions",
        )
        ax.plot(
            values["index"][null],
            height[null],
            "s",
            markerfacecolor="white",
            markeredgecolor=PROPOSED,
            markeredgewidth=1.4,
            markersize=6,
            label=f"{null.sum()} counted as zero",
        )
        ax.axhline(
            values["tolerance"].iloc[0],
            color=LINE,
            linestyle="--",
            linewidth=1,
            label="limit: below it, zero",
        )
        ax.set_yscale("log")
        ax.set_ylim(_FLOOR, 3)
        ax.set_xlim(0, len(values) + 1)
        ax.set_xlabel(f"index of the singular value (of {len(values)})")
        ax.set_ylabel("singular value / largest")
        if len(directions):
            held = ", ".join(map(symbol, directions["held"]))
            ax.set_title(f"fixed: {held}", fontsize=9)
        ax.legend(loc="center left", bbox_to_anchor=(0.0, 0.3), fontsize=8)
    return figure
