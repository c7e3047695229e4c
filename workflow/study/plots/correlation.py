"""The figure of the correlations between the estimated parameters: a matrix, grouped by arm, scanner and planes."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import LINE, new_figure, styled, symbol

_GROUPS = (
    ("lengths of the arm", r"[ad]_\d+"),
    ("angles of the arm", r"(alpha|theta|beta)_\d+"),
    ("scanner", r"sensor_"),
    ("planes", r"(normal|distance)_"),
    ("other", ""),
)
_SHOWN = 0.7  # correlations of a larger absolute value are written as numbers


def grouped(names: list[str]) -> tuple[list[str], dict[str, int]]:
    """Return the names ordered by group, and ``{group: number of names}``; names that belong to no group come last, as ``other``."""
    order: list[str] = []
    sizes: dict[str, int] = {}
    for group, pattern in _GROUPS:
        found = [name for name in names if name not in order and re.match(pattern, name)]
        if found:
            order += found
            sizes[group] = len(found)
    return order, sizes


def draw_correlation(correlation: pd.DataFrame) -> Figure:
    """Return the figure: colours show the correlations, and numbers the absolute values of those above ``_SHOWN``.

    Args:
        correlation: As ``study.headline.workspace.correlation`` returns it.
    """
    table = correlation.set_index("parameter")
    names, sizes = grouped([str(name) for name in table.index])
    matrix = table.loc[names, names].to_numpy(dtype=float)
    count = len(names)
    with styled():
        figure = new_figure(8.6, 5.4)
        ax = figure.subplots()
        shown = ax.imshow(matrix, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
        bar = figure.colorbar(shown, ax=ax, shrink=0.7, pad=0.02)
        bar.set_label("correlation of the estimates")
        ax.grid(visible=False)
        for spine in ax.spines.values():
            spine.set_visible(False)
        ax.set_xticks(range(count), list(map(symbol, names)), rotation=90, fontsize=8)
        ax.set_yticks(range(count), list(map(symbol, names)), fontsize=8)
        ax.tick_params(length=0)
        edge = 0
        for group, size in sizes.items():
            middle = edge + (size - 1) / 2
            ax.text(middle, -1.1, group, ha="center", va="bottom", fontsize=9, fontweight="bold")
            edge += size
            if edge < count:
                ax.axhline(edge - 0.5, color=LINE, linewidth=1.0)
                ax.axvline(edge - 0.5, color=LINE, linewidth=1.0)
        for i, j in zip(*np.nonzero(np.abs(np.tril(matrix, -1)) > _SHOWN), strict=True):
            text = f"{abs(matrix[i, j]):.2f}".replace("0.", ".")
            ax.text(float(j), float(i), text, ha="center", va="center", fontsize=7.5, color="white")
    return figure
