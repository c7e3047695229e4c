"""The figure of sequential calibration: errors after every pass, and the ratio of the errors after one pass to those of fitting all at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from study.common.statistics import BAND
from study.plots.style import COLOURS, GRID, LINE, LOOKS, PROPOSED, Look, new_figure, numeral, styled

_AT_ONCE = Look("all at once", PROPOSED, "o")
_WAYS = {
    "scanner_first": Look("scanner first, then arm", COLOURS["scanner first"], "^"),
    "robot_first": Look("arm first, scanner as declared", COLOURS["arm first"], "s"),
    "robot_first_linear": Look("arm first, scanner at linear guess", COLOURS["arm first, linear"], "v"),
}
_INITIAL = LOOKS["initial"]
_QUANTITY = "position_mean_mm"
_FROM_MIDDLE = 0.26
"""Share of a row's height by which the first and the last way are drawn above and below its middle."""
_BETWEEN_PANELS = 0.08
"""Room left of the labels of the right panel's rows, as a share of a panel's width: closer to the left panel, they read as its labels."""


def draw_sequential(errors: pd.DataFrame, summary: pd.DataFrame) -> Figure:
    """Return a figure with two panels: errors over the passes in the case with repeated passes, and ratios of errors after one pass in every case.

    Args:
        errors: As ``study.sequential.compare.compare_sequential`` returns them.
        summary: Their summary, as ``study.sequential.summary`` returns it.
    """
    raw: Any = errors[(errors["alignment"] == "raw") & errors[_QUANTITY].notna()]
    with styled():
        figure = new_figure(9.2, 4.6)
        left, right = figure.subplots(1, 2, width_ratios=[1, 1.15], gridspec_kw={"wspace": _BETWEEN_PANELS})
        alternating: Any = summary[summary["stage"] == "alternating"]
        case = alternating["case"].iloc[0] if len(alternating) else raw["case"].iloc[0]
        _by_passes(left, raw[raw["case"] == case])
        poses, off, by = _words(summary, case)
        left.set_title(f"{poses}\n{off} {by}", fontsize=9)
        _single_passes(right, raw, summary)
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def _by_passes(ax: Axes, rows: Any) -> None:
    """Draw median and band over the seeds after each pass; a seed that has converged stays where it is."""
    at_once = rows[rows["way"] == "at_once"][_QUANTITY]
    before = rows[rows["way"] == "initial"][_QUANTITY]
    most = max(int(rows["passes"].max()), 1)
    low, middle, high = at_once.quantile([BAND[0], 0.5, BAND[1]])
    ax.axhspan(low, high, color=_AT_ONCE.colour, alpha=0.25, linewidth=0)
    ax.axhline(middle, color=_AT_ONCE.colour, linewidth=1.8, label=f"{_AT_ONCE.label}: {numeral(middle)} mm")
    for way, look in _WAYS.items():
        own = rows[rows["way"] == way]
        table = own.pivot(index="seed", columns="passes", values=_QUANTITY)
        table = table.reindex(columns=range(1, most + 1)).ffill(axis=1)
        bands = table.quantile([BAND[0], 0.5, BAND[1]]).to_numpy()
        x = np.arange(1, most + 1)
        ax.fill_between(x, bands[0], bands[2], color=look.colour, alpha=0.15, linewidth=0)
        ax.plot(x, bands[1], color=look.colour, marker=look.marker, markersize=5, label=look.label)
    ax.plot(
        [0], [before.median()], _INITIAL.marker, color=_INITIAL.colour, markersize=7, linestyle="none", label="initial model (median)"
    )  # fmt: skip
    ax.set_yscale("log")
    _plain_numbers(ax.yaxis, (1.0, 2.0, 5.0))
    ax.set_xlim(-0.3, most + 0.3)
    ax.set_xticks(range(0, most + 1, max(1, most // 6)))
    ax.set_xlabel("passes (each block is fitted once per pass)")
    ax.set_ylabel("mean position error [mm]")


def _single_passes(ax: Axes, raw: Any, summary: pd.DataFrame) -> None:
    """Draw a row for each case, with a dot for each seed: the ratio of the error after one pass to that of fitting all at once."""
    cases = list(dict.fromkeys(raw["case"]))
    places = dict(zip(_WAYS, np.linspace(_FROM_MIDDLE, -_FROM_MIDDLE, len(_WAYS)), strict=True))
    for i, case in enumerate(cases):
        own = raw[raw["case"] == case]
        at_once = own[own["way"] == "at_once"].set_index("seed")[_QUANTITY]
        for way, look in _WAYS.items():
            one = own[(own["way"] == way) & (own["passes"] == 1)].set_index("seed")[_QUANTITY]
            ratios = (one / at_once).dropna().sort_index()
            y = -i + places[way] + np.linspace(-0.07, 0.07, len(ratios))
            ax.plot(
                ratios, y, look.marker, color=look.colour, markersize=3.4, alpha=0.6, linestyle="none", markeredgewidth=0
            )  # fmt: skip
            ax.plot(
                [ratios.median()] * 2, -i + places[way] + np.array([-0.11, 0.11]), color=LINE, linewidth=1.6
            )
        before = own[own["way"] == "initial"].set_index("seed")[_QUANTITY]
        ax.plot(
            [(before / at_once).median()],
            [-i - 0.4],
            _INITIAL.marker,
            color=_INITIAL.colour,
            markersize=6,
            markeredgewidth=0,
        )
    ax.axvline(1, color=_AT_ONCE.colour, linewidth=1.8)
    ax.set_xscale("log")
    ax.set_yticks(
        [-i for i in range(len(cases))], ["\n".join(_words(summary, case)) for case in cases], fontsize=8
    )
    ax.set_ylim(-len(cases) + 0.42, 0.45)
    ax.grid(visible=False, axis="y")
    ax.tick_params(axis="y", length=0)
    _plain_numbers(ax.xaxis, (1.0,))
    for i in range(1, len(cases)):
        ax.axhline(0.45 - i, color=GRID, linewidth=0.6)
    ax.set_xlabel("error after one pass / error of all at once (mean position)")
    ax.set_title("left of the line a single pass is better", fontsize=9)


def _plain_numbers(axis: Axis, labelled: tuple[float, ...]) -> None:
    """Label some multiples of each decade of a logarithmic axis, as decimal numbers, and no other tick."""
    axis.set_major_locator(LogLocator(subs=labelled))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def _words(summary: pd.DataFrame, case: str) -> tuple[str, str, str]:
    """Return the lines of a case's label: its poses and noise, and in two lines the errors of its initial model."""
    row: Any = summary[summary["case"] == case].iloc[0]
    lengths, angles = numeral(row["length_error_mm"]), numeral(row["angle_error_deg"])
    return (
        f"{row['poses']} poses, noise {numeral(row['noise_mm'])} mm",
        "initial model off",
        f"by {lengths} mm, {angles}°",
    )
