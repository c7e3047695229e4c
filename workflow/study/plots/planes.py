"""The figure of the errors of the calibrated planes, with the bounds that the original paper states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.plots.style import LOOKS, PUBLISHED, new_figure, styled, with_unit

_COLUMNS = {
    "distance_error_mm": "size of the distance error [mm]",
    "normal_error_deg": "angle between the normals [°]",
}

_EDGE = 1e-5
"""Smaller errors [mm or deg] are drawn at this value: a logarithmic axis has no place for the error zero of a plane whose initial guess is exact."""


def draw_planes(planes: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """Return a figure of the errors of distance and normal: a column for each plane and method, with a dot for each seed that converged.

    Args:
        planes: planes.csv.
        published: published_plane_errors.csv.
    """
    shown: Any = planes[planes["status"] == "converged"]
    methods, names = list(dict.fromkeys(shown["method"])), list(dict.fromkeys(planes["plane"]))
    step = 0.8 / max(len(methods), 1)
    with styled():
        figure = new_figure(9.6, 3.6)
        axes = figure.subplots(1, 2)
        for ax, (column, label) in zip(axes, _COLUMNS.items(), strict=True):
            for (method, name), rows in shown.groupby(["method", "plane"], sort=False):
                look, k = LOOKS[method], names.index(name)
                x = k + (methods.index(method) - (len(methods) - 1) / 2) * step
                offsets = np.linspace(-0.3, 0.3, len(rows)) * step
                label_once = look.label if k == 0 else None
                ax.plot(
                    x + offsets,
                    rows[column].abs().clip(lower=_EDGE),
                    look.marker,
                    color=look.colour,
                    markersize=3.2,
                    linestyle="none",
                    label=label_once,
                )
            claim = float(published[column].iloc[0])
            text = f"paper: within {with_unit(claim, column)}"
            line = ax.axhline(claim, color=PUBLISHED, linestyle="--", linewidth=1.2)
            ax.legend([line], [text], loc="upper right")
            ax.set_yscale("log")
            ax.set_ylim(_EDGE / 2, 5 * ax.get_ylim()[1])  # room for the legend
            ax.set_ylabel(label)
            ax.set_xticks(range(len(names)), names)
            ax.grid(visible=False, axis="x")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=max(len(labels), 1))
    return figure
