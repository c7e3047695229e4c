"""The figure of position errors over the workspace, from the side and from above: before, after, and as the calibration predicts them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from scalar.units import MM, UM
from study.plots.style import LINE, new_figure, numeral, styled

_VIEWS = (("side", "distance from the base's axis [m]", "height [m]"), ("above", "x [m]", "y [m]"))
_STATES = (
    ("before_mm", "before"),
    ("after_mm", "after, found"),
    ("predicted_mm", "after, predicted"),
)
_FEWEST = 3  # cells with fewer poses are not shown


def draw_workspace(errors: pd.DataFrame, seeds: int) -> Figure:
    """Return a map for each state and view; the errors after calibration, found and predicted, share one scale of colours.

    Args:
        errors: As ``study.headline.workspace.map_errors`` returns them.
        seeds: The number of seeds over which they are taken.
    """
    enough: Any = errors[errors["poses"] >= _FEWEST]
    with styled():
        figure = new_figure(9.2, 5.5)
        if enough.empty:
            figure.text(0.5, 0.5, "no fit gave a calibration", ha="center")
            return figure
        axes = figure.subplots(2, 3, height_ratios=[1.1, 1])
        after = _range(enough, ["after_mm", "predicted_mm"])
        for column, (state, title) in zip(axes.T, _STATES, strict=True):
            low, high = _range(enough, [state]) if state == "before_mm" else after
            factor, unit = (1.0, "mm") if state == "before_mm" else (MM / UM, "µm")
            for ax, (view, across, up) in zip(column, _VIEWS, strict=True):
                rows = enough[enough["view"] == view]
                x, y, grid = _grid(rows, state)
                shown = ax.pcolormesh(
                    x,
                    y,
                    grid * factor,
                    cmap="viridis",
                    vmin=low * factor,
                    vmax=high * factor,
                    rasterized=True,
                )
                ax.set_aspect("equal")
                # The view from the side is narrow, and has room for two ticks.
                ax.locator_params(axis="x", nbins=2 if view == "side" else 4, min_n_ticks=1)
                ax.set_xlabel(across)
                if ax in axes[:, 0]:
                    ax.set_ylabel(up)
                ax.plot([0], [0], "+", color=LINE, markersize=9, markeredgewidth=1.6, clip_on=False)
            whole = np.sqrt(np.average(rows[state] ** 2, weights=rows["poses"])) * factor
            column[0].set_title(f"{title}: {numeral(whole)} {unit}", fontsize=9.5)
            bar = figure.colorbar(
                shown, ax=list(column), location="bottom", aspect=28, extend="both", pad=0.02
            )
            bar.set_label(f"position error, root mean square [{unit}]")
        figure.suptitle(f"root mean square over {seeds} repetitions; + is the robot's base", fontsize=9)
    return figure


def _range(errors: Any, states: list[str]) -> tuple[float, float]:
    """Return the least and the greatest value [mm] of the colours: the 2 and 98 % quantiles of the cells."""
    values = errors[states].to_numpy()
    return float(np.quantile(values, 0.02)), float(np.quantile(values, 0.98))


def _grid(rows: Any, state: str) -> tuple[Any, Any, Any]:
    """Return the edges of the cells [m] and their values, blank where there is none."""
    u, v = np.unique(rows["u_m"]), np.unique(rows["v_m"])
    size = min(np.diff(u).min(initial=np.inf), np.diff(v).min(initial=np.inf))
    i = np.rint((rows["u_m"] - u[0]) / size).astype(int)
    j = np.rint((rows["v_m"] - v[0]) / size).astype(int)
    grid = np.full((j.max() + 1, i.max() + 1), np.nan)
    grid[j, i] = rows[state]
    x = u[0] + size * (np.arange(grid.shape[1] + 1) - 0.5)
    y = v[0] + size * (np.arange(grid.shape[0] + 1) - 0.5)
    return x, y, np.ma.masked_invalid(grid)
