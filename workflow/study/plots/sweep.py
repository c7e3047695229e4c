"""Errors over a sweep: a panel a quantity, a band a way, the bound, the published points, and what failed below."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter, NullLocator

from study.plots.style import LOOKS, PUBLISHED_COLOUR, QUANTITY_LABELS, new_figure, numeral, styled

_PANELS = (("position_mean_mm", "position_max_mm"), ("orientation_mean_deg", "orientation_max_deg"))
BOUND_ROWS = "cramer-rao"
_LINES: dict[str, Any] = {
    "proposed": "-",
    "baseline-abs": "--",
    "baseline-abs-2018": (0, (5, 1, 1, 1, 1, 1)),
    "baseline-clip": "-.",
    "baseline-raise": ":",
}
_FLOOR = {"mm": 1e-4, "deg": 1e-5}  # smaller errors are drawn as triangles on the lower edge
_ZERO = 3.0  # on a logarithmic axis 0 stands this factor left of the smallest value
_NEAR = 0.055  # of the axis: labels of ticks nearer than this to one another are left out, numbers are turned


def draw_sweep(summary: pd.DataFrame, published: pd.DataFrame, label: str, scale: str = "log") -> Figure:
    """Return the figure of a sweep for one kind of walls.

    Args:
        summary: The rows of summary.csv of these walls. published: Those of published_curves.csv of this sweep;
            none where the paper has no such sweep.
        label: Of the x axis. scale: "log" or "linear", of the x axis.
    """
    raw: Any = summary[summary["alignment"] == "raw"]
    methods = [name for name in LOOKS if name != "initial" and name in set(raw["method"])]
    values = np.unique(raw["value"].to_numpy(dtype=float))
    with styled():
        figure = new_figure(9.6, 7.6 + 0.36 * len(methods))
        heights = [3.4, 3.4, 0.27 * len(methods) + 0.05]
        axes = figure.subplots(3, 2, sharex=True, height_ratios=heights)
        for row, names in zip(axes, _PANELS, strict=False):
            for ax, quantity in zip(row, names, strict=True):
                draw_panel(ax, raw, published, methods, quantity, scale)
        for ax in axes[2]:
            set_x_axis(ax, values, label, scale)
            write_failures(ax, raw, methods, values, scale)
        seeds = int(raw.loc[raw["method"] != BOUND_ROWS, "seeds"].max())
        figure.legend(
            handles=legend_entries(methods, seeds, len(published) > 0), loc="outside upper center", ncols=3
        )
    return figure


def draw_panel(ax: Axes, raw: Any, published: Any, methods: list[str], quantity: str, scale: str) -> None:
    """Draw one quantity: bands and medians, the bound, the paper's points."""
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
    ax.plot(
        place_values(bound["value"], values, scale),
        bound["median"],
        ":",
        color="black",
        linewidth=1.8,
        zorder=4,
    )
    if len(published):
        x = place_values(published["value"], values, scale)
        ax.plot(
            x,
            published[quantity],
            "o",
            color=PUBLISHED_COLOUR,
            markersize=6,
            markeredgecolor="white",
            zorder=5,
        )
    ax.set_yscale("log")
    ax.set_ylabel(QUANTITY_LABELS[quantity])
    bottom, top = ax.get_ylim()
    ax.set_ylim(max(bottom, floor), top)


def place_values(value: Any, values: np.ndarray, scale: str) -> np.ndarray:
    """Return where values stand on the axis; on a logarithmic one, 0 has a place of its own."""
    x = np.asarray(value, dtype=float)
    return np.where(x == 0, values[values > 0].min() / _ZERO, x) if scale == "log" else x


def set_x_axis(ax: Axes, values: np.ndarray, label: str, scale: str) -> None:
    """Set ticks at the cases, labels where there is room."""
    ax.set_xscale(scale)
    at = place_values(values, values, scale)
    place = np.log(at) if scale == "log" else at
    width, last, labels = np.ptp(place) or 1.0, -np.inf, []
    for x, value in zip(place, values, strict=True):
        room = x - last >= _NEAR * width
        labels.append(numeral(value, 4) if room else "")
        last = x if room else last
    ax.set_xticks(at, labels, fontsize=7.5, rotation=45 if len(values) > 7 else 0)
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(label)


def write_failures(ax: Axes, raw: Any, methods: list[str], values: np.ndarray, scale: str) -> None:
    """Write for each method and case how many fits failed, and how many converged elsewhere."""
    rows = raw[raw["quantity"] == "position_mean_mm"]
    at = place_values(values, values, scale)
    at = np.log(at) if scale == "log" else at
    gaps = np.diff(at, prepend=-np.inf, append=np.inf) / (np.ptp(at) or 1.0)
    near = dict(zip(values, np.minimum(gaps[:-1], gaps[1:]) < _NEAR, strict=True))
    for line, method in enumerate(methods):
        mine = rows[rows["method"] == method]
        for row in mine.to_dict("records"):
            x = float(place_values(row["value"], values, scale))
            text = str(row["failed"] + row["lost"])
            none = text == "0"
            look: Any = {
                "color": "#aaaaaa" if none else LOOKS[method].colour,
                "fontweight": "normal" if none else "bold",
            }
            place: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7.5}
            if near[row["value"]]:
                place |= {"fontsize": 7.5, "rotation": 90}  # upright numbers would stand on one another
            ax.text(x, -line, "·" if none else text, **place, **look).set_in_layout(False)
    ax.set_ylim(-len(methods) + 0.5, 0.5)
    names = [LOOKS[method].label.replace("baseline, ", "") for method in methods]
    ax.set_yticks(-np.arange(len(methods)), names, fontsize=7.5)
    ax.tick_params(axis="y", length=0)
    ax.grid(visible=False)
    ax.set_ylabel("failed\n+ lost", fontsize=7.5, rotation=0, ha="right", va="center")


def legend_entries(methods: list[str], seeds: int, has_published: bool) -> list[Line2D | Patch]:
    ways: list[Line2D | Patch] = []
    for method in methods:
        look = LOOKS[method]
        style = {"linestyle": _LINES[method], "marker": look.marker, "markersize": 4.5}
        ways.append(Line2D([], [], color=look.colour, label=look.label, **style))
    ways.append(Patch(facecolor="#555555", alpha=0.2, label=f"5 to 95 % of {seeds} seeds; line: median"))
    ways.append(Line2D([], [], color="black", linestyle=":", linewidth=1.8, label="Cramér-Rao bound"))
    if has_published:
        ways.append(
            Line2D([], [], color="black", linestyle="none", marker="o", label="paper (one run a point)")
        )
    return ways
