"""The figure of a sweep: a panel for each quantity with bands of the methods, the bound and published points, and below them the failed fits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import NullFormatter, NullLocator

from study.plots.style import (
    BAND,
    LINE,
    LOOKS,
    PROPOSED_DARK,
    PUBLISHED,
    QUANTITY_LABELS,
    QUANTITY_PANELS,
    decimal_ticks,
    new_figure,
    numeral,
    spaced_labels,
    styled,
)

BOUND_ROWS = "cramer-rao"
_LINES: dict[str, Any] = {
    "proposed": "-",
    "proposed-tolerance": (0, (3, 1)),
    "baseline-abs": "--",
    "baseline-abs-2018": (0, (5, 1, 1, 1, 1, 1)),
    "baseline-clip": "-.",
    "baseline-raise": ":",
}
_MEANS: dict[str, Any] = {
    "color": PROPOSED_DARK,
    "linestyle": "none",
    "marker": "x",
    "markersize": 5.5,
    "markeredgewidth": 1.3,
    "zorder": 6,
}
_FLOOR = {"mm": 1e-4, "deg": 1e-5}  # smaller errors are drawn as triangles on the lower edge
_ZERO = 3.0  # on a logarithmic axis, zero is drawn at the smallest value divided by this
_NEAR_IN = 0.36  # labels of ticks nearer than this to one another are left out [in]
_END = 0.04  # share of the axis by which the first and the last cell of a strip reach beyond their case
_STRIP = 0.8  # height of a method's strip of failures, as a share of the distance between two strips


def draw_sweep(summary: pd.DataFrame, published: pd.DataFrame, label: str, scale: str = "log") -> Figure:
    """Return the figure of a sweep for one kind of walls.

    Args:
        summary: The rows of summary.csv of these walls.
        published: The rows of published_curves.csv of this sweep; none if the original paper has no such sweep.
        label: Label of the x axis.
        scale: Scale of the x axis, "log" or "linear".
    """
    raw: Any = summary[summary["alignment"] == "raw"]
    methods = [name for name in LOOKS if name != "initial" and name in set(raw["method"])]
    values = np.unique(raw["value"].to_numpy(dtype=float))
    with styled():
        figure = new_figure(9.6, 7.6 + 0.36 * len(methods))
        heights = [3.4, 3.4, 0.27 * len(methods) + 0.05]
        axes = figure.subplots(3, 2, sharex=True, height_ratios=heights)
        for row, names in zip(axes, QUANTITY_PANELS, strict=False):
            for ax, quantity in zip(row, names, strict=True):
                draw_panel(ax, raw, published, methods, quantity, scale)
        for ax in axes[2]:
            set_x_axis(ax, values, label, scale)
            draw_failures(ax, raw, methods, values, scale)
        seeds = int(raw.loc[raw["method"] != BOUND_ROWS, "seeds"].max())
        figure.legend(
            handles=legend_entries(methods, seeds, len(published) > 0), loc="outside upper center", ncols=3
        )
    return figure


def draw_panel(ax: Axes, raw: Any, published: Any, methods: list[str], quantity: str, scale: str) -> None:
    """Draw one quantity: the bands and medians of the methods, the bound, and the published points.

    The bound is one of the error's mean over the noise: it is drawn as its mean over the seeds, beside the mean of the proposed method at the cases
    in which every fit succeeds.

    Args:
        ax: The axes to draw in.
        raw: The rows of summary.csv without alignment.
        published: The published points of the sweep.
        methods: Names of the methods, in the order of drawing.
        quantity: The column that is drawn, such as ``position_mean_mm``.
        scale: ``log`` or ``linear``, of the horizontal axis.
    """
    rows = raw[raw["quantity"] == quantity]
    values = np.unique(rows["value"].to_numpy(dtype=float))
    floor = _FLOOR["mm" if quantity.endswith("_mm") else "deg"]
    for method in methods:
        look, mine = LOOKS[method], rows[rows["method"] == method].sort_values("value")
        mine = mine[mine["median"].notna()]
        if mine.empty:
            continue
        x = place_values(mine["value"], values, scale)
        shown = np.maximum(mine[["p05", "median", "p95"]].to_numpy(dtype=float), floor / 10)
        ax.fill_between(x, shown[:, 0], shown[:, 2], color=look.colour, alpha=0.16, linewidth=0)
        style = {"color": look.colour, "linestyle": _LINES[method], "linewidth": 1.5}
        ax.plot(x, shown[:, 1], marker=look.marker, markersize=4.5, markeredgewidth=0, **style)
        small = shown[:, 1] < floor
        ax.plot(x[small], np.full(small.sum(), floor * 1.25), "v", color=look.colour, markersize=4)
    bound = rows[rows["method"] == BOUND_ROWS].sort_values("value")
    style = {"color": LINE, "linewidth": 1.8, "zorder": 4}
    ax.plot(place_values(bound["value"], values, scale), bound["mean"], ":", **style)
    means = rows[(rows["method"] == "proposed") & (rows["failed"] + rows["lost"] == 0)]
    means = means[means["value"].isin(bound["value"]) & (means["mean"] >= floor)]
    ax.plot(place_values(means["value"], values, scale), means["mean"], **_MEANS)
    if len(published):
        x = place_values(published["value"], values, scale)
        ax.plot(
            x,
            published[quantity],
            "o",
            color=PUBLISHED,
            markersize=6,
            markeredgecolor="white",
            zorder=5,
        )
    ax.set_yscale("log")
    decimal_ticks(ax.yaxis)
    ax.set_ylabel(QUANTITY_LABELS[quantity])
    bottom, top = ax.get_ylim()
    ax.set_ylim(max(bottom, floor), top)


def place_values(value: Any, values: np.ndarray, scale: str) -> np.ndarray:
    """Return where values ``(...)`` are drawn on an axis; on a logarithmic one, 0 is drawn at a fixed ratio below the smallest positive value.

    Args:
        value: ``(...)``, the values to draw.
        values: ``(V,)``, all values of the axis.
        scale: ``log`` or ``linear``.
    """
    x = np.asarray(value, dtype=float)
    return np.where(x == 0, values[values > 0].min() / _ZERO, x) if scale == "log" else x


def set_x_axis(ax: Axes, values: np.ndarray, label: str, scale: str) -> None:
    """Set a tick at each case, with a label if there is room for it.

    Args:
        ax: The axes.
        values: ``(V,)``, the values of the cases.
        label: Label of the axis.
        scale: ``log`` or ``linear``.
    """
    ax.set_xscale(scale)
    at = place_values(values, values, scale)
    places = _along(at, scale)
    figure: Any = ax.get_figure()
    width = float(ax.get_position().width * figure.get_size_inches()[0])
    labels = [numeral(value, 4) for value in values]
    ax.set_xticks(at, spaced_labels(list(places), labels, _NEAR_IN / width), fontsize=8)
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(label)


def _along(at: np.ndarray, scale: str) -> np.ndarray:
    """Return positions on an axis as shares of the distance between the first and the last."""
    place = np.log(at) if scale == "log" else at
    return (place - place.min()) / (np.ptp(place) or 1.0)


def draw_failures(ax: Axes, raw: Any, methods: list[str], values: np.ndarray, scale: str) -> None:
    """Draw a strip for each method: a cell for each case, which is darker if more of its fits failed or converged elsewhere.

    The number of such fits in all cases is written on the right. A cell reaches half the way to its neighbours, so that its case is in its middle.
    """
    rows = raw[raw["quantity"] == "position_mean_mm"]
    at = place_values(values, values, scale)
    places = np.log(at) if scale == "log" else at
    ends = places[[0, -1]] + _END * (np.ptp(places) or 1.0) * np.array([-1.0, 1.0])
    edges = np.concatenate([ends[:1], (places[1:] + places[:-1]) / 2, ends[1:]])
    edges = np.exp(edges) if scale == "log" else edges
    for line, method in enumerate(methods):
        mine: Any = rows[rows["method"] == method].set_index("value")
        ended = mine["failed"] + mine["lost"]
        for k, value in enumerate(values):
            share = float(ended[value] / mine.loc[value, "seeds"]) if value in mine.index else 0.0
            place = (edges[k], -line - _STRIP / 2)
            look: Any = {"facecolor": LOOKS[method].colour, "edgecolor": "none"}
            ax.add_patch(Rectangle(place, edges[k + 1] - edges[k], _STRIP, alpha=share, **look))
        ax.annotate(
            str(int(ended.sum())), (1.0, -line), xycoords=("axes fraction", "data"), fontsize=8,
            xytext=(3, 0), textcoords="offset points", ha="left", va="center", annotation_clip=False,
        )  # fmt: skip
    ax.set_ylim(-len(methods) + 0.5, 0.5)
    names = [LOOKS[method].label.replace("baseline, ", "").replace(" method", "") for method in methods]
    ax.set_yticks(-np.arange(len(methods)), names, fontsize=8)
    ax.tick_params(axis="y", length=0)
    ax.grid(visible=False)


def legend_entries(methods: list[str], seeds: int, has_published: bool) -> list[Line2D | Patch]:
    """Return the entries of the legend: the methods, the band, the bound, and the published points if there are any."""
    entries: list[Line2D | Patch] = []
    for method in methods:
        look = LOOKS[method]
        style = {"linestyle": _LINES[method], "marker": look.marker, "markersize": 4.5}
        entries.append(Line2D([], [], color=look.colour, label=look.label, **style))
    entries.append(Patch(facecolor=BAND, alpha=0.2, label=f"5 to 95 % of {seeds} seeds; line: median"))
    entries.append(
        Line2D([], [], color=LINE, linestyle=":", linewidth=1.8, label="Cramér-Rao bound of the mean error")
    )
    if "proposed" in methods:
        entries.append(Line2D([], [], **_MEANS, label="mean of the proposed method, for the bound"))
    if has_published:
        entries.append(
            Line2D([], [], color=PUBLISHED, linestyle="none", marker="o", label="published (one run a point)")
        )
    return entries
