"""The picture of a plan: the position of each joint in the order of the program, and the expected error over the number of poses."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM

_WIDTH, _ROW = 8.0, 0.75  # inches
_BLUE, _GREY = "#2a6fb0", "#9a9a9a"


def draw_plan(
    q: Array, robot: Robot, curve: list[tuple[int, float]], random: tuple[int, float] | None
) -> bytes:
    """Return the picture of a plan as PNG.

    Args:
        q: ``(k, n)`` [rad; m of a joint that slides], in the order of the program.
        robot: The arm, whose joint limits are drawn.
        curve: Numbers of poses and expected errors [m]; may be empty.
        random: One such pair for poses drawn at random, or None.
    """
    n = q.shape[1]
    rows = max(n, 4)
    figure = Figure(figsize=(_WIDTH, _ROW * rows + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(n, 2 if curve else 1, width_ratios=[3, 2] if curve else [1])
    shared = None
    for j in range(n):
        axes = figure.add_subplot(grid[j, 0], sharex=shared)
        shared = shared or axes
        size, unit = (MM, "mm") if j in robot.prismatic else (DEG, "°")
        axes.plot(np.arange(1, len(q) + 1), q[:, j] / size, "o-", ms=2.5, lw=0.6, color=_BLUE)
        low, high = robot.limits[j] / size
        axes.set_ylim(low - 0.04 * (high - low), high + 0.04 * (high - low))
        axes.axhline(low, color=_GREY, lw=0.6, ls=":")
        axes.axhline(high, color=_GREY, lw=0.6, ls=":")
        axes.set_ylabel(f"q{j + 1} [{unit}]", fontsize=8)
        axes.tick_params(labelsize=7, labelbottom=j == n - 1)
    assert shared is not None
    figure.axes[n - 1].set_xlabel("pose, in the order of the program", fontsize=8)
    if curve:
        axes = figure.add_subplot(grid[:, 1])
        counts, errors = np.array(curve).T
        axes.plot(counts, errors / MM, "o-", ms=3.5, lw=1.0, color=_BLUE, label="planned")
        if random is not None:
            axes.plot(random[0], random[1] / MM, "x", color=_GREY, ms=7, mew=1.5, label="drawn at random")
        axes.set_xlabel("number of poses", fontsize=8)
        axes.set_ylabel("expected error of a predicted position [mm RMS]", fontsize=8)
        axes.set_ylim(bottom=0)
        axes.tick_params(labelsize=7)
        axes.legend(fontsize=8, frameon=False, loc="upper right")
    picture = BytesIO()
    figure.savefig(picture, dpi=150, format="png")
    return picture.getvalue()
