"""Pose errors before and after calibration, over the seeds, beside the published values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from scalar.plots.style import LOOKS, PUBLISHED_COLOUR, QUANTITY_LABELS, new_figure, numeral, styled

_SPREAD = 0.11  # half the width over which the dots of one column stand
_RAW, _ALIGNED = -0.17, 0.19  # where they stand beside the tick
_PANELS = (("position_mean_mm", "position_max_mm"), ("orientation_mean_deg", "orientation_max_deg"))


def draw_errors(errors: pd.DataFrame, summary: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """Return a panel a quantity, a column a method: a dot a seed, a band, the median, the paper's values.

    Args:
        errors: errors.csv. summary: summary.csv. published: published_headline.csv, one row a state.
    """
    methods = list(dict.fromkeys(errors["method"]))
    stated: Any = published.set_index("state")
    with styled():
        figure = new_figure(9.6, 7.2)
        axes = figure.subplots(2, 2, sharex=True)
        for row, names in zip(axes, _PANELS, strict=True):
            for ax, quantity in zip(row, names, strict=True):
                for i, method in enumerate(methods):
                    for alignment, offset in (("raw", _RAW), ("aligned", _ALIGNED)):
                        _column(ax, i + offset, errors, summary, (method, alignment, quantity))
                _published(ax, methods, stated[quantity])
                ax.set_yscale("log")
                ax.set_ylabel(QUANTITY_LABELS[quantity])
                ax.set_xticks(range(len(methods)), [LOOKS[m].label.replace(", ", ",\n") for m in methods])
                ax.tick_params(axis="x", length=0)
                ax.grid(visible=False, axis="x")
                ax.set_xlim(-0.6, len(methods) - 0.4)
        figure.legend(handles=_legend(len(errors["seed"].unique())), loc="outside upper center", ncols=3)
    return figure


def _column(
    ax: Axes, x: float, errors: pd.DataFrame, summary: pd.DataFrame, key: tuple[str, str, str]
) -> None:
    method, alignment, quantity = key
    look = LOOKS[method]
    at = (errors["method"] == method) & (errors["alignment"] == alignment)
    values = errors.loc[at, quantity].dropna().to_numpy(dtype=float)
    at = (
        (summary["method"] == method)
        & (summary["alignment"] == alignment)
        & (summary["quantity"] == quantity)
    )
    band: Any = summary[at].iloc[0]
    if not len(values):
        return
    width = 2.6 * _SPREAD
    ax.bar(
        x, band["p95"] - band["p05"], width, bottom=band["p05"], color=look.colour, alpha=0.22, linewidth=0
    )
    filled = alignment == "raw"
    ax.plot(
        x + np.linspace(-_SPREAD, _SPREAD, len(values)),
        values,
        look.marker,
        markersize=3.2,
        markerfacecolor=look.colour if filled else "white",
        markeredgecolor=look.colour,
        markeredgewidth=0.6,
        linestyle="none",
    )
    ax.plot(
        [x - width / 2, x + width / 2],
        [band["median"]] * 2,
        color="black",
        linewidth=1.4,
        solid_capstyle="butt",
    )
    if filled:
        ax.annotate(
            numeral(band["mean"], 2),
            (x, band["max"]),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
        )


def _published(ax: Axes, methods: list[str], stated: Any) -> None:
    """Draw what the paper states: a cross beside the initial models, a line across the calibrated ones."""
    if "initial" in methods:
        x = methods.index("initial") + _RAW
        ax.plot(
            [x], [stated["initial"]], "x", color=PUBLISHED_COLOUR, markersize=9, markeredgewidth=2.2, zorder=5
        )
        label = f"paper {numeral(stated['initial'], 4)}"
        ax.annotate(
            label,
            (x, stated["initial"]),
            xytext=(-8, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=7.5,
        )
        ax.set_xlim(left=-1.0)
    ax.plot(
        [0.5, len(methods) - 0.45], [stated["calibrated"]] * 2, "--", color=PUBLISHED_COLOUR, linewidth=1.2
    )
    label = f"paper {numeral(stated['calibrated'])}"
    ax.annotate(
        label,
        (0.5, stated["calibrated"]),
        xytext=(-3, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        fontsize=7.5,
    )


def _legend(n_seeds: int) -> list[Line2D | Patch]:
    grey = {"color": "#555555", "linestyle": "none", "marker": "o", "markersize": 4}
    return [
        Line2D([], [], **grey, label="raw, a dot a seed (held parameters at their truth)"),
        Line2D([], [], **grey, markerfacecolor="white", label="aligned (best rigid move of the base)"),
        Patch(facecolor="#555555", alpha=0.22, label=f"5 to 95 % of {n_seeds} seeds"),
        Line2D([], [], color="black", linewidth=1.4, label="median; number: mean over the seeds, raw"),
        Line2D(
            [],
            [],
            color="black",
            linestyle="none",
            marker="x",
            markersize=8,
            markeredgewidth=2,
            label="paper, initial model",
        ),
        Line2D(
            [], [], color="black", linestyle="--", linewidth=1.2, label="paper, calibrated (one run, raw)"
        ),
    ]
