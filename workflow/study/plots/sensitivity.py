"""The figure of the settings that change an answer when they are halved or doubled: the share of blind sets in which each does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from study.plots.setting_labels import label_of
from study.plots.style import LINE, PROPOSED, PROPOSED_LIGHT, new_figure, styled

NAMING = (PROPOSED, "what is refused, named, or named where")
OTHER = (PROPOSED_LIGHT, "another statement or number")


def draw_sensitivity(table: pd.DataFrame, most: int = 30) -> Figure:
    """Return bars to the left for settings halved and to the right for settings doubled, the most influential at the top.

    Args:
        table: settings.csv.
        most: Largest number of settings that are shown.
    """
    changed = ["changed_halved", "changed_doubled"]
    shown: Any = table[table[changed].sum(axis=1) > 0].head(most)[::-1]
    sets = shown["sets"].to_numpy(dtype=float)
    with styled():
        figure = new_figure(7.2, 1.2 + 0.15 * max(len(shown), 1))
        ax = figure.subplots()
        place = np.arange(len(shown))
        for sign, direction in ((-1, "halved"), (1, "doubled")):
            naming, any_change = (
                sign * 100 * shown[f"{what}_{direction}"].to_numpy(dtype=float) / sets
                for what in ("naming", "changed")
            )
            ax.barh(place, any_change - naming, left=naming, color=OTHER[0], height=0.75)
            ax.barh(place, naming, color=NAMING[0], hatch="///", edgecolor="white", linewidth=0, height=0.75)
        labels = [f"{label_of(row['setting'])}  ({row['sets']})" for row in shown.to_dict("records")]
        ax.set_yticks(place, labels, fontsize=7)
        ax.axvline(0, color=LINE, linewidth=0.8)
        ax.set_xlim(-105, 105)
        ax.set_xticks([-100, -50, 0, 50, 100], ["100", "50", "0", "50", "100"])
        ax.set_xlabel("← halved    share of the sets whose answer changes [%]    doubled →", fontsize=8)
        ax.set_ylim(-0.6, max(len(shown), 1) - 0.4)
        ax.grid(axis="y", visible=False)
        handles = [
            Patch(facecolor=NAMING[0], hatch="///", edgecolor="white", label=NAMING[1]),
            Patch(facecolor=OTHER[0], label=OTHER[1]),
        ]
        figure.legend(handles=handles, loc="outside upper center", ncols=2, fontsize=8)
    return figure
