"""The figure of the distribution of the errors of the simulated initial models, and of where the published initial model falls in it."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import LOOKS, PUBLISHED, QUANTITY_LABELS, new_figure, styled, with_unit


def draw_initial(errors: pd.DataFrame, placed: pd.DataFrame) -> Figure:
    """Return a figure with a panel for each quantity: the share of the simulated initial models below each value, and the published model.

    Args:
        errors: errors.csv.
        placed: published_among_simulated.csv.
    """
    look = LOOKS["initial"]
    initial = errors[(errors["method"] == "initial") & (errors["alignment"] == "raw")]
    rows: Any = placed[placed["method"] == "initial"].set_index("quantity")
    with styled():
        figure = new_figure(9.6, 2.9)
        for ax, (quantity, label) in zip(
            figure.subplots(1, 4, sharey=True), QUANTITY_LABELS.items(), strict=True
        ):
            row = rows.loc[quantity]
            ax.ecdf(initial[quantity], color=look.colour, linewidth=1.8)
            ax.plot(
                initial[quantity],
                [-4.0e-2] * len(initial),
                "|",
                color=look.colour,
                markersize=6,
                clip_on=False,
            )
            ax.axvline(row["published"], color=PUBLISHED, linestyle="--", linewidth=1.4)
            ax.set_title(_place(row, quantity), fontsize=8.5)
            ax.set_xlabel(label)
            ax.set_xlim(left=0)
            ax.set_ylim(-0.08, 1.02)
            if quantity == "position_mean_mm":
                ax.set_ylabel(f"share of {int(row['seeds'])} simulated initial models")
    return figure


def _place(row: Any, quantity: str) -> str:
    """Return the title of a panel: the published value, and the share of the simulated ones below it."""
    value = f"published {with_unit(row['published'], quantity, 4)}:"
    if row["percentile"] >= 100:
        return f"{value}\nabove all simulated ones"
    if row["percentile"] <= 0:
        return f"{value}\nbelow all simulated ones"
    return f"{value}\nabove {row['percentile']:.0f} % of the simulated"
