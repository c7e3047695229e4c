"""The figure of the share of right answers over the stated confidence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.confidence.fit import KINDS
from study.plots.style import EDGE, PROPOSED, new_figure, styled

TITLES = {
    "effect": "effects",
    "component": "variance components",
    "structure": "unmodelled structure",
}


def draw_confidence(reliability: pd.DataFrame) -> Figure:
    """Return a reliability diagram for each kind of answer; each half of the trials has the confidence fitted to the other half.

    Args:
        reliability: reliability.csv.
    """
    with styled():
        figure = new_figure(8.6, 2.7)
        for ax, kind in zip(figure.subplots(1, len(KINDS), sharex=True, sharey=True), KINDS, strict=True):
            some: Any = reliability[(reliability["kind"] == kind) & (reliability["answers"] > 0)]
            x, y = (some[name].to_numpy(dtype=float) for name in ("mean_stated", "share"))
            low, high = (some[name].to_numpy(dtype=float) for name in ("low", "high"))
            ax.plot([0, 1], [0, 1], "--", color=EDGE, linewidth=1.2)
            ax.errorbar(x, y, np.maximum([y - low, high - y], 0.0), fmt="o", color=PROPOSED, capsize=3)
            for at, bottom, n in zip(x, low, some["answers"], strict=True):
                words: Any = {"xytext": (0, -3), "textcoords": "offset points", "ha": "center", "va": "top"}
                ax.annotate(str(int(n)), (at, bottom), fontsize=7.5, **words)
            ax.set_title(TITLES[kind])
            ax.set_xlabel("stated confidence")
            ax.set_xlim(0, 1.02)
            ax.set_ylim(0, 1.03)
        figure.axes[0].set_ylabel("share of right answers")
    return figure
