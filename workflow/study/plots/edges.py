"""The figure of the mean position error, and of the shares of right, wrong and refused answers, over the degree of each fault of the data."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from study.edges.axes import AXES
from study.plots.style import (
    BAND,
    COLOURS,
    FAINT,
    LINE,
    LOOKS,
    PAGE_IN,
    PROPOSED,
    new_figure,
    styled,
)

COLOURS_OF = {
    "right": PROPOSED,
    "unattributed": COLOURS["unattributed"],
    "wrong": COLOURS["wrong name"],
    "refused": FAINT,
    "crashed": LINE,
}
HATCHES = {"right": "", "unattributed": "\\\\\\", "wrong": "///", "refused": "", "crashed": ""}
LABELS = {
    "right": "right answer",
    "unattributed": "found, not named",
    "wrong": "wrong, or missed",
    "refused": "refused, with the reason",
    "crashed": "crashed",
}
_COLUMNS = 3


def draw_edges(rows: Any, summary: Any) -> Figure:
    """Return a figure with a panel of errors above a panel of answers for each kind of fault.

    Args:
        rows: edges.csv.
        summary: The summary of these rows, summary.csv.
    """
    names = [name for name in AXES if name in set(summary["axis"])]
    bands = int(np.ceil(len(names) / _COLUMNS))
    with styled():
        figure = new_figure(PAGE_IN, 0.5 + 2.2 * bands)
        grid = figure.subplots(
            2 * bands, _COLUMNS, height_ratios=[1.6, 1.0] * bands, squeeze=False, sharey=False
        )
        errors = rows["position_after_mm"].dropna()
        low, high = (0.5 * errors.min(), 2.0 * errors.max()) if len(errors) else (1e-3, 1.0)
        for k in range(_COLUMNS * bands):
            top, bottom = grid[2 * (k // _COLUMNS), k % _COLUMNS], grid[2 * (k // _COLUMNS) + 1, k % _COLUMNS]
            if k >= len(names):
                top.remove()
                bottom.remove()
                continue
            sets, table = rows[rows["axis"] == names[k]], summary[summary["axis"] == names[k]]
            values = table["value"].to_numpy(dtype=float)
            at = {value: i for i, value in enumerate(values)}
            top.plot(sets["value"].map(at), sets["position_after_mm"], "o", ms=2.5, color=BAND, alpha=0.6)
            top.plot(range(len(values)), table["position_median_mm"], "-", color=LOOKS["proposed"].colour)
            top.set_yscale("log")
            top.set_ylim(low, high)
            top.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            top.yaxis.set_major_formatter("{x:g}")
            top.yaxis.set_minor_formatter(NullFormatter())
            top.tick_params(which="both", labelsize=7)
            base = np.zeros(len(values))
            for answer, colour in COLOURS_OF.items():
                share = 100 * table[answer].to_numpy(dtype=float)
                bottom.bar(
                    range(len(values)), share, bottom=base, color=colour, hatch=HATCHES[answer],
                    edgecolor="white", linewidth=0, width=0.8,
                )  # fmt: skip
                base += share
            bottom.set_ylim(0, 100)
            bottom.set_xlabel(AXES[names[k]].label, fontsize=8)
            for ax in (top, bottom):
                ax.set_xlim(-0.6, len(values) - 0.4)
                ax.set_xticks(range(len(values)), [f"{v:g}" for v in values] if ax is bottom else [])
            if k % _COLUMNS == 0:
                top.set_ylabel("mean position\nerror [mm]")
                bottom.set_ylabel("answers [%]")
            else:
                top.tick_params(which="both", labelleft=False)
                bottom.tick_params(labelleft=False)
        shown = [answer for answer in COLOURS_OF if summary[answer].any()]
        handles = [
            Patch(facecolor=COLOURS_OF[a], hatch=HATCHES[a], edgecolor="white", linewidth=0, label=LABELS[a])
            for a in shown
        ]
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=8)
    return figure
