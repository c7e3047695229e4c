"""The figures of the blind trials.

They show the names given for each injected effect, the answers over the size of the effect, the errors after the diagnosis, and the share of right
answers over the stated confidence.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from scalar.units import DEG, MM, UM
from study.common.effect_words import case_words
from study.plots.style import (
    COLOURS,
    EDGE,
    FAINT,
    LINE,
    PROPOSED,
    PROPOSED_DARK,
    PROPOSED_LIGHT,
    decimal_ticks,
    new_figure,
    styled,
)

KINDS = (  # column of power.csv, words, colour, hatch: distinguished in grey as well
    ("right", "named right, target included", PROPOSED, ""),
    ("listed", "another name, the right one listed beside it", COLOURS["another name"], "///"),
    ("elsewhere", "right name, wrong target", COLOURS["wrong target"], "..."),
    ("wrong", "wrong name", COLOURS["wrong name"], "xxx"),
    ("unattributed", "unattributed", COLOURS["unattributed"], "\\\\\\"),
    ("unobservable", "declared unobservable", COLOURS["unobservable"], ""),
    ("missed", "nothing found", COLOURS["nothing"], ""),
)
_GREYS = LinearSegmentedColormap.from_list("shares", ["white", PROPOSED_LIGHT, PROPOSED_DARK])
_SHOWN_IN = {  # {unit of the tables: (factor, unit of the figure)}: angles in degrees, lengths in millimetres
    "rad": (1.0 / DEG, "°"),
    "rad/(N m)": (1000.0 / DEG, "°/(kN m)"),
    "m": (1.0 / MM, "mm"),
    "m/m": (1.0 / UM, "µm/m"),
    "rad/rad": (1.0 / UM, "10⁻⁶"),
    "1/m": (1.0, "1/m"),
}
_WHOLE_FROM = 10.0  # ratios from here on are written without decimals
_LEAST_SHOWN = 0.0001  # smaller numbers below a bar are written as less than this
_DARK = 0.55  # share of a row above which a cell of the matrix is so dark that its text is white


def draw_confusion(confusion: pd.DataFrame, least_size: float = 1.0) -> Figure:
    """Return the confusion matrix: a row for what was injected, a column for the first name given, counts as text and shares of the row as colour.

    Args:
        confusion: confusion.csv.
        least_size: Least size that is counted, as a multiple of the natural size.
    """
    table: Any = confusion[confusion["size"] >= least_size]
    cases = list(dict.fromkeys(table["case"]))
    names = list(dict.fromkeys([*(case.split("-")[0] for case in cases), *table["named"]]))
    last = ["unattributed", "none", "failed"]
    names = [n for n in names if n not in last and n != "unknown"] + [
        n for n in last if n in set(table["named"])
    ]
    counts = np.zeros((len(cases), len(names)))
    for row in table.to_dict("records"):
        counts[cases.index(row["case"]), names.index(row["named"])] += row["count"]
    share = counts / counts.sum(axis=1, keepdims=True)
    with styled():
        figure = new_figure(9.2, 1.9 + 0.23 * len(cases))
        ax = figure.subplots()
        ax.imshow(share, cmap=_GREYS, vmin=0, vmax=1, aspect="auto")
        for i, j in np.argwhere(counts > 0):
            colour = "white" if share[i, j] > _DARK else "black"
            ax.text(j, i, f"{counts[i, j]:.0f}", ha="center", va="center", fontsize=8, color=colour)
        for i, case in enumerate(cases):
            wanted = "unattributed" if case.startswith("unknown") else case.split("-")[0]
            if wanted in names:
                ax.add_patch(_frame(names.index(wanted), i))
        ax.set_xticks(
            range(len(names)), [case_words(n) for n in names], rotation=45, ha="left", rotation_mode="anchor"
        )
        ax.xaxis.tick_top()
        ax.set_yticks(
            range(len(cases)),
            [f"{case_words(c)}  ({int(n)})" for c, n in zip(cases, counts.sum(1), strict=True)],
        )
        ax.tick_params(length=0, labelsize=8)
        ax.set_ylabel("injected (number of sets)")
        ax.set_xlabel("named first")
        ax.xaxis.set_label_position("top")
        ax.grid(visible=False)
        for side in ax.spines.values():
            side.set_visible(False)
    return figure


def _frame(x: float, y: float) -> Any:
    """Return the frame around the cell of the right name."""
    from matplotlib.patches import Rectangle

    return Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, edgecolor=LINE, linewidth=1.3)


def draw_power(power: pd.DataFrame, thresholds: pd.DataFrame) -> Figure:
    """Return a panel for each case: how often it is named right over its size, and which answers are given instead.

    Args:
        power: power.csv.
        thresholds: thresholds.csv.
    """
    cases = list(dict.fromkeys(power["case"]))
    columns = 5
    rows = int(np.ceil(len(cases) / columns))
    with styled():
        figure = new_figure(9.2, 0.9 + 1.6 * rows)
        axes = np.atleast_2d(figure.subplots(rows, columns, sharey=True))
        for ax in axes.ravel()[len(cases) :]:
            ax.set_axis_off()
        for ax, case in zip(axes.ravel(), cases, strict=False):
            threshold: Any = thresholds[thresholds["case"] == case].iloc[0]
            _power_panel(ax, power[power["case"] == case], threshold)
        for ax in axes[:, 0]:
            ax.set_ylabel("share of sets")
        handles: list[Any] = [
            Patch(facecolor=colour, hatch=hatch, edgecolor=EDGE, linewidth=0.4, label=label)
            for _, label, colour, hatch in KINDS
        ]
        handles.append(
            Line2D([], [], color=LINE, marker="|", markersize=9, label="half named right, 95 % interval")
        )
        figure.legend(handles=handles, loc="outside upper center", ncols=4, fontsize=8)
    return figure


def _power_panel(ax: Axes, rows: Any, threshold: Any) -> None:
    """Draw one case: a stack of outcomes for each size, and above them the size at which half of the sets are named right."""
    sizes = rows["size_in_unit"].to_numpy(dtype=float)
    place = np.log10(sizes)
    width = 0.72 * np.min(np.diff(place)) if len(place) > 1 else 0.3
    below = np.zeros(len(rows))
    total = rows["right_sets"].to_numpy(dtype=float)
    for name, _, colour, hatch in KINDS:
        part = rows[name].to_numpy(dtype=float) / total
        style: Any = {"color": colour, "hatch": hatch, "edgecolor": EDGE, "linewidth": 0.4}
        ax.bar(place, part, width, bottom=below, **style)
        below += part
    if threshold["half_size"] > 0:
        low, high = threshold["half_size_low"], threshold["half_size_high"]
        left = np.log10(low) if low > 0 else place[0] - 0.4
        right = np.log10(high) if np.isfinite(high) else place[-1] + 0.4
        ax.plot([left, right], [1.07, 1.07], color=LINE, linewidth=1.4, clip_on=False)
        ax.plot([np.log10(threshold["half_size"])], [1.07], "|", color=LINE, markersize=9, clip_on=False)
    labels = []
    factor, unit = _SHOWN_IN[str(rows["unit"].iloc[0])]
    for size, signal in zip(sizes * factor, rows["signal_over_noise"], strict=True):
        labels.append(f"{_short(size)}\n{_short(signal) if np.isfinite(signal) else '–'}")
    ax.set_xticks(place, labels, fontsize=8)
    ax.margins(x=0.01)
    ax.set_ylim(0, 1.13)
    ax.set_yticks([0, 0.5, 1])
    ax.grid(visible=False, axis="x")
    ax.set_title(f"{case_words(rows['case'].iloc[0])}\n[{unit}]", fontsize=8, pad=7)


def _short(value: float) -> str:
    """Return a number rounded to one digit; a number below ``_LEAST_SHOWN`` as less than that."""
    return f"{float(f'{value:.1g}'):.4g}" if value >= _LEAST_SHOWN else f"<{_LEAST_SHOWN:.4f}"


def draw_errors_after(errors: pd.DataFrame, size: float = 1.0) -> Figure:
    """Return the position error before, after and of the matched control, a row for each case, medians over the sets named right.

    Args:
        errors: errors.csv.
        size: The size that is shown, as a multiple of the natural size.
    """
    rows: Any = errors[(errors["size"] == size) & (errors["sets"] > 0) & errors["mean_after_mm"].notna()]
    rows = rows[~rows["case"].str.startswith("null")]
    place = -np.arange(len(rows))
    with styled():
        figure = new_figure(8.6, 1.0 + 0.175 * len(rows))
        ax = figure.subplots()
        columns = [rows[f"mean_{when}_mm"].to_numpy(dtype=float) for when in ("before", "after", "control")]
        before, after, control = columns
        ax.hlines(place, np.min(columns, axis=0), np.max(columns, axis=0), color=FAINT, linewidth=1.2)
        look: Any = {"linestyle": "none", "markersize": 7, "markeredgecolor": LINE, "markeredgewidth": 0.7}
        ax.plot(before, place, "D", color=FAINT, label="before: no effect in the model", **look)
        ax.plot(after, place, "o", color=PROPOSED, label="after: the effects found in the model", **look)
        bar: Any = {"color": LINE, "markersize": 9, "markeredgewidth": 1.8, "linestyle": "none"}
        ax.plot(control, place, "|", label="matched control: the same scene without the effect", **bar)
        ax.set_xscale("log")
        decimal_ticks(ax.xaxis)
        ax.set_xlabel("mean position error over 10,000 poses, base aligned [mm]")
        ratio = rows["after_over_control"].to_numpy(dtype=float)
        right = ax.secondary_yaxis("right")
        right.set_yticks(place, [f"{r:.2f}" if r < _WHOLE_FROM else f"{r:.0f}" for r in ratio], fontsize=7.5)
        right.set_ylabel("after / matched control, median", fontsize=8)
        right.tick_params(length=0)
        ax.set_yticks(
            place,
            [f"{case_words(c)}  ({n})" for c, n in zip(rows["case"], rows["sets"], strict=True)],
            fontsize=8,
        )
        ax.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper center", ncols=3, fontsize=8)
    return figure


def draw_reliability(reliability: pd.DataFrame) -> Figure:
    """Return the share of named effects that are injected, over the confidence that the diagnosis states.

    Args:
        reliability: reliability.csv.
    """
    stated: Any = reliability[reliability["by"] == "confidence"]
    with styled():
        figure = new_figure(5.4, 4.6)
        ax = figure.subplots()
        ax.plot([0, 1], [0, 1], "--", color=EDGE, linewidth=1.2, label="as stated")
        x = stated["mean_stated"].to_numpy(dtype=float)
        y = stated["right_share"].to_numpy(dtype=float)
        low, high = (stated[f"right_{side}"].to_numpy(dtype=float) for side in ("low", "high"))
        ax.errorbar(
            x, y, [y - low, high - y], fmt="o", color=PROPOSED, capsize=3, label="measured, 95 % interval"
        )
        # Numbers of confidences that are so near to one another stand below one another.
        near = np.diff(x, prepend=-1.0) < 0.04
        level = 0
        for at, share, n, lower in zip(x, y, stated["answers"], near, strict=True):
            level = level + 1 if lower else 0
            note: Any = {"xytext": (6, -10 - 10 * level), "textcoords": "offset points", "fontsize": 7.5}
            ax.annotate(str(int(n)), (at, share), **note)
        ax.set_xlabel("confidence stated with an effect")
        ax.set_ylabel("share of those effects that were injected")
        ax.set_xlim(0, 1.02)
        ax.set_ylim(0, 1.03)
        ax.legend(loc="lower right")
    return figure
