"""The figure of all sweeps: the mean position error of each, for one kind of walls, on one page of a paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import LOOKS, new_figure, styled
from study.plots.sweep import (
    BOUND_ROWS,
    draw_failures,
    draw_panel,
    legend_entries,
    place_values,
    set_x_axis,
)

COLUMNS = 3
_LONGEST = 36  # characters of a label that fit on one line below a panel
QUANTITY = "position_mean_mm"


def draw_overview(
    summaries: Mapping[str, pd.DataFrame], published: pd.DataFrame, axes: Mapping[str, Mapping[str, Any]]
) -> Figure:
    """Return a figure with a panel for each sweep, and below it a strip with the shares of fits that failed.

    Methods that only some of the sweeps have are shown in the figures of these sweeps alone.

    Args:
        summaries: ``{sweep: rows of its summary.csv of these walls}``.
        published: published_curves.csv.
        axes: ``{sweep: {"label", "scale", "published"}}``: label and scale of the axis, and the name of the published curve, as in the config.
    """
    rows = int(np.ceil(len(summaries) / COLUMNS))
    columns = min(COLUMNS, len(summaries))
    seeds = 0
    in_all = set.intersection(*(set(summary["method"]) for summary in summaries.values()))
    methods = [name for name in LOOKS if name != "initial" and name in in_all]
    with styled():
        figure = new_figure(
            3.06 * columns if columns > 1 else 4.3, (0.9 if columns > 1 else 1.8) + 2.75 * rows
        )
        grid = figure.subplots(2 * rows, columns, squeeze=False, height_ratios=[3.0, 1.3] * rows)
        for ax in grid.ravel()[2 * columns * (rows - 1) :]:
            ax.set_axis_off()
        for k, (name, summary) in enumerate(summaries.items()):
            raw: Any = summary[summary["alignment"] == "raw"]
            values = np.unique(raw["value"].to_numpy(dtype=float))
            scale = axes[name].get("scale", "log")
            curve = published[published["sweep"] == axes[name].get("published")]
            above, below = grid[2 * (k // COLUMNS) : 2 * (k // COLUMNS) + 2, k % COLUMNS]
            above.set_axis_on()
            below.set_axis_on()
            draw_panel(above, raw, curve, methods, QUANTITY, scale)
            set_x_axis(below, values, _wrapped(axes[name]["label"]), scale)
            above.set_xscale(scale)
            above.set_xlim(*_range(values, scale))
            above.tick_params(axis="x", which="both", length=0, labelbottom=False)
            draw_failures(below, raw, methods, values, scale)
            below.set_xlim(*_range(values, scale))
            if k % COLUMNS:
                above.set_ylabel("")
                below.set_yticklabels([])
            seeds = max(seeds, int(raw.loc[raw["method"] != BOUND_ROWS, "seeds"].max()))
        entries = legend_entries(methods, seeds, True)
        # A single panel is too narrow for entries side by side.
        figure.legend(handles=entries, loc="outside upper center", ncols=3 if columns > 1 else 1, fontsize=8)
    return figure


def _wrapped(label: str) -> str:
    """Return a label; if it is too long for one line, its unit is put on a second one."""
    return label.replace(" [", "\n[") if len(label) > _LONGEST else label


def _range(values: np.ndarray, scale: str) -> tuple[float, float]:
    """Return the ends of an axis, a twentieth of its length beyond its values."""
    at = place_values(values, values, scale)
    if scale != "log":
        margin = 0.05 * float(np.ptp(at))
        return float(at.min()) - margin, float(at.max()) + margin
    margin = (at.max() / at.min()) ** 0.05
    return float(at.min() / margin), float(at.max() * margin)
