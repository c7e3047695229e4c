"""The figure of the error of each parameter and the standard error stated for it (section IV-D of the original paper)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.plots.style import COLOURS, LINE, LOOKS, new_figure, styled, symbol

_LIMIT = 5.0  # standard errors: larger errors are drawn at this value


def draw_parameters(parameters: pd.DataFrame, summary: pd.DataFrame, method: str) -> Figure:
    """Return a figure with three panels (lengths, angles, errors over standard errors) that have a column for each parameter.

    Args:
        parameters: parameters.csv.
        summary: parameter_summary.csv.
        method: The method whose errors are drawn.
    """
    look = LOOKS[method]
    rows: Any = summary[summary["method"] == method]
    with_std: Any = parameters[(parameters["method"] == method) & parameters["std"].notna()]
    with styled():
        figure = new_figure(8.6, 4.9)
        if rows.empty:
            figure.text(0.5, 0.5, f"{look.label}: no fit gave standard errors", ha="center")
            return figure
        panels = figure.subplot_mosaic([["mm", "deg"], ["normalized", "normalized"]], height_ratios=[1, 1.1])
        for unit, title in (("mm", "lengths"), ("deg", "angles")):
            _draw_errors(panels[unit], rows[rows["unit"] == unit], unit, title, look.colour)
        ax = panels["normalized"]
        names = list(rows["parameter"])
        ax.axhspan(-2, 2, color=COLOURS["nothing"], label="±2 standard errors: 95 % should lie inside")
        ax.axhline(0, color=LINE, linewidth=0.8)
        shown = with_std["normalized_error"].clip(-_LIMIT, _LIMIT)
        offset = with_std["seed"].rank(method="dense", pct=True) - 0.5  # seeds side by side in the column
        x = with_std["parameter"].map({name: i for i, name in enumerate(names)}) + 0.6 * offset
        ax.plot(
            x,
            shown,
            look.marker,
            color=look.colour,
            markersize=3,
            alpha=0.55,
            linestyle="none",
            label=f"one seed (at ±{_LIMIT:g} if beyond)",
        )
        for side in (-1, 1):
            edge = (side * rows["normalized_rms"]).clip(-_LIMIT, _LIMIT)
            label = "± their root mean square (should be 1)" if side > 0 else None
            ax.plot(
                range(len(names)),
                edge,
                "_",
                color=LINE,
                markersize=11,
                markeredgewidth=2,
                label=label,
            )
        ax.set_yticks([-4, -2, 0, 2, 4])
        ax.set_ylim(-_LIMIT - 0.3, _LIMIT + 1.7)  # room for the legend
        ax.set_ylabel("error / standard error")
        _name_columns(ax, names)
        ax.set_title(f"{look.label}: errors over the seeds in standard errors", fontsize=9)
        ax.legend(loc="upper center", ncols=3, fontsize=7.5, columnspacing=1.0)
    return figure


def _draw_errors(ax: Axes, rows: pd.DataFrame, unit: str, title: str, colour: str) -> None:
    """Draw the stated standard error and the root mean square error of each parameter with a unit."""
    x = np.arange(len(rows))
    ax.bar(
        x,
        rows["std_mean"],
        0.75,
        color=colour,
        alpha=0.3,
        label="standard error stated, mean over the seeds",
    )
    ax.plot(
        x,
        rows["error_rms"],
        "_",
        color=LINE,
        markersize=9,
        markeredgewidth=2,
        label="error found, root mean square",
    )
    ax.set_ylabel(f"{title} [{'°' if unit == 'deg' else unit}]")
    ax.set_ylim(bottom=0)
    ax.margins(y=0.4)
    _name_columns(ax, list(rows["parameter"]))
    ax.legend(loc="upper left", fontsize=7.5)


def _name_columns(ax: Axes, names: list[str]) -> None:
    """Label the columns with the symbols of the parameters."""
    ax.set_xticks(range(len(names)), list(map(symbol, names)), fontsize=9)
    ax.set_xlim(-0.7, len(names) - 0.3)
    ax.grid(visible=False, axis="x")
