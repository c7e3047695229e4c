"""The figure of pose errors before and after calibration, over the seeds, with the published values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from study.plots.style import (
    BAND,
    LINE,
    LOOKS,
    PUBLISHED,
    QUANTITY_LABELS,
    QUANTITY_PANELS,
    decimal_ticks,
    new_figure,
    numeral,
    rounded,
    styled,
)

_HALF_WIDTH = 0.11  # half the width over which the dots of one column are spread
_STATED, _RAW, _ALIGNED = -0.5, -0.17, 0.19
"""Positions of the published dot and of the columns of raw and of aligned errors, relative to the tick of a method."""


_DOT: Any = {"color": PUBLISHED, "linestyle": "none", "marker": "o", "markersize": 7}
"""How the published error of the initial model is drawn: as the published points in all figures."""


def draw_errors(errors: pd.DataFrame, summary: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """Return a figure with a panel for each quantity and, for each method, its raw and aligned errors and the published value.

    Args:
        errors: errors.csv.
        summary: summary.csv.
        published: published_headline.csv, one row for each state.
    """
    methods = list(dict.fromkeys(errors["method"]))
    stated: Any = published.set_index("state")
    with styled():
        figure = new_figure(9.2, 5.8)
        axes = figure.subplots(2, 2, sharex=True)
        for row, names in zip(axes, QUANTITY_PANELS, strict=True):
            for ax, quantity in zip(row, names, strict=True):
                for i, method in enumerate(methods):
                    for alignment, offset in (("raw", _RAW), ("aligned", _ALIGNED)):
                        _column(ax, i + offset, errors, summary, (method, alignment, quantity))
                _published(ax, methods, stated[quantity])
                ax.set_yscale("log")
                decimal_ticks(ax.yaxis)
                ax.set_ylabel(QUANTITY_LABELS[quantity])
                ax.set_xticks(range(len(methods)), [_tick(method, summary) for method in methods])
                ax.tick_params(axis="x", length=0, labelsize=8)
                ax.grid(visible=False, axis="x")
                ax.set_xlim(-1.15, len(methods) - 0.4)
        handles = _legend(len(errors["seed"].unique()))
        figure.legend(handles=handles, loc="outside upper center", ncols=2, fontsize=8)
    return figure


def _column(
    ax: Axes, x: float, errors: pd.DataFrame, summary: pd.DataFrame, key: tuple[str, str, str]
) -> None:
    """Draw one method and alignment: a band, the median, a dot for each seed, and a cross for each seed with which it did not converge."""
    method, alignment, quantity = key
    look, raw = LOOKS[method], alignment == "raw"
    rows: Any = errors[(errors["method"] == method) & (errors["alignment"] == alignment)]
    band: Any = summary[
        (summary["method"] == method)
        & (summary["alignment"] == alignment)
        & (summary["quantity"] == quantity)
    ].iloc[0]
    if rows[quantity].isna().all():
        return
    width = 2.6 * _HALF_WIDTH
    height = band["p95"] - band["p05"]
    ax.bar(x, height, width, bottom=band["p05"], color=look.colour, alpha=0.22, linewidth=0)
    at = x + np.linspace(-_HALF_WIDTH, _HALF_WIDTH, len(rows))
    converged = rows["status"].isin(["converged", "initial"]).to_numpy(dtype=bool)
    for which, marker in ((converged, look.marker), (~converged, "x")):
        ax.plot(
            at[which],
            rows[quantity][which],
            marker,
            markersize=3.2,
            markerfacecolor=look.colour if raw else "white",
            markeredgecolor=look.colour,
            markeredgewidth=0.6 if marker != "x" else 1.0,
            linestyle="none",
        )
    ends = [x - width / 2, x + width / 2]
    ax.plot(ends, [band["median"]] * 2, color=LINE, linewidth=1.4, solid_capstyle="butt")
    if raw:
        place = {"xytext": (0, 4), "textcoords": "offset points", "ha": "center", "fontsize": 8}
        ax.annotate(rounded(band["mean"], 2), (x, band["max"]), **place)


def _published(ax: Axes, methods: list[str], stated: Any) -> None:
    """Draw what the original paper states: a dot beside the initial models, and a line across the calibrated ones."""
    place = {"textcoords": "offset points", "ha": "right", "va": "center", "fontsize": 8}
    if "initial" in methods:
        x = methods.index("initial") + _STATED
        ax.plot([x], [stated["initial"]], **_DOT)
        ax.annotate(numeral(stated["initial"], 4), (x, stated["initial"]), xytext=(-7, 0), **place)
    ax.plot([0.5, len(methods) - 0.45], [stated["calibrated"]] * 2, "--", color=PUBLISHED, linewidth=1.2)
    ax.annotate(
        f"published {numeral(stated['calibrated'])}", (0.5, stated["calibrated"]), xytext=(-3, 0), **place
    )


def _tick(method: str, summary: pd.DataFrame) -> str:
    """Return a method's name, and how many of its fits did not converge."""
    row: Any = summary[summary["method"] == method].iloc[0]
    name = (
        LOOKS[method]
        .label.replace("baseline, ", "")
        .replace("lmfit of", "lmfit\nof")
        .replace(" model", "\nmodel")
        .replace(" method", "\nmethod")
        .replace(" (", "\n(")
        .replace("|, ", "|\n")
    )
    return f"{name}\n({row['not_converged']} of {row['seeds']}\nfailed)" if row["not_converged"] else name


def _legend(n_seeds: int) -> list[Line2D | Patch]:
    """Return the entries of the legend, of which one states the number of seeds."""
    grey = {"color": BAND, "linestyle": "none", "marker": "o", "markersize": 4}
    return [
        Line2D([], [], **grey, label="raw, one dot per seed (fixed parameters at their true values)"),
        Line2D([], [], **grey, markerfacecolor="white", label="aligned (best rigid motion of the base)"),
        Patch(facecolor=BAND, alpha=0.22, label=f"5 to 95 % of {n_seeds} seeds"),
        Line2D([], [], color=LINE, linewidth=1.4, label="median; number: mean over the seeds, raw"),
        Line2D(
            [],
            [],
            **_DOT,
            label="published, initial model (one run, raw)",
        ),
        Line2D(
            [],
            [],
            color=PUBLISHED,
            linestyle="--",
            linewidth=1.2,
            label="published, calibrated (one run, raw)",
        ),
    ]
