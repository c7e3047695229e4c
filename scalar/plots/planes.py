"""How near the calibrated planes come to the true ones, beside what the paper states."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from scalar.plots.style import LOOKS, PUBLISHED_COLOUR, new_figure, numeral, styled

_COLUMNS = (
    ("distance_error_mm", "size of the distance error [mm]", "mm"),
    ("normal_error_deg", "angle of the normals [°]", "°"),
)
_FLOOR = 1e-7  # an error that is exactly zero (a rough guess taken from the truth) is left out of a log axis


def draw_planes(planes: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """Return the errors of distance and normal, a column a plane and method, a dot a seed.

    Args:
        planes: planes.csv. published: published_plane_errors.csv.
    """
    calibrated = planes[planes["method"] != "initial"]
    methods, names = list(dict.fromkeys(calibrated["method"])), list(dict.fromkeys(calibrated["plane"]))
    step = 0.8 / len(methods)
    with styled():
        figure = new_figure(9.6, 3.6)
        for ax, (column, label, unit) in zip(figure.subplots(1, 2), _COLUMNS, strict=True):
            for i, method in enumerate(methods):
                look = LOOKS[method]
                for k, name in enumerate(names):
                    at = (calibrated["method"] == method) & (calibrated["plane"] == name)
                    size = calibrated.loc[at, column].abs()
                    size = size[size > _FLOOR]
                    x = k + (i - (len(methods) - 1) / 2) * step + np.linspace(-0.3, 0.3, len(size)) * step
                    face = look.colour
                    shown = look.label if k == 0 else None
                    ax.plot(x, size, look.marker, color=face, markersize=3.2, linestyle="none", label=shown)
            claim = float(published[column].iloc[0])
            text = f"paper: within {numeral(claim)} {unit}"
            ax.axhline(claim, color=PUBLISHED_COLOUR, linestyle="--", linewidth=1.2, label=text)
            ax.set_yscale("log")
            ax.set_ylabel(label)
            ax.set_xticks(range(len(names)), names)
            ax.grid(visible=False, axis="x")
        handles, labels = figure.axes[0].get_legend_handles_labels()
        more = figure.axes[1].get_legend_handles_labels()
        figure.legend([*handles, more[0][-1]], [*labels, more[1][-1]], loc="outside upper center", ncols=3)
    return figure
