"""The figure of the workcell: the image that pybullet renders, with the names of base, scanner and target planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.patheffects import withStroke

from study.plots.style import new_figure, styled

_WIDTH = 5.0  # in: scaled to the width of a column of the paper, text of 9 pt becomes 6 pt
_MARGIN = 12  # pixels of background that are kept on every side of the workcell
_BACKGROUND = 0.995  # brightness from which a pixel counts as background


def draw_scene(picture: str | Path, places: Mapping[str, Sequence[float]]) -> Figure:
    """Return the figure: the rendered image without the background around the workcell, its parts named.

    Args:
        picture: The rendered image, a PNG file.
        places: ``{name: (x, y)}``, where each name is written, in pixels of the image from its upper left corner: ``base``, ``scanner``,
            and the name of each target plane.
    """
    image: Any = imread(picture)[..., :3]
    rows, columns = np.nonzero((image < _BACKGROUND).any(axis=2))
    top, left = max(rows.min() - _MARGIN, 0), max(columns.min() - _MARGIN, 0)
    image = image[top : rows.max() + _MARGIN, left : columns.max() + _MARGIN]
    height, width = image.shape[:2]
    with styled():
        figure = new_figure(_WIDTH, _WIDTH * height / width)
        figure.set_layout_engine("none")
        ax = figure.add_axes((0, 0, 1, 1))
        ax.imshow(image, interpolation="antialiased", aspect="auto")
        ax.set_axis_off()
        halo = [withStroke(linewidth=3, foreground="white", alpha=0.8)]
        for name, (x, y) in places.items():
            at = (x - left, y - top)
            if name == "scanner":
                arrow = {"arrowstyle": "-", "color": "black", "linewidth": 0.8, "shrinkB": 6}
                ax.annotate(
                    "scanner and its fan", at, xytext=(at[0] - 0.02 * width, at[1] + 0.2 * height),
                    ha="center", fontsize=9, arrowprops=arrow, path_effects=halo,
                )  # fmt: skip
            elif name == "base":
                ax.annotate(
                    "base",
                    at,
                    xytext=(0, -20),
                    textcoords="offset points",
                    ha="center",
                    fontsize=9,
                    path_effects=halo,
                )
            else:
                ax.annotate(
                    name.replace("_", " "), at, ha="center", va="center", fontsize=10, fontweight="bold"
                )
    return figure
