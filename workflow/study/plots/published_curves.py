"""The figures of the published curves: published points with predictions, the support of each candidate, and the recovery of injected candidates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from scalar.units import DEG, MRAD
from study.plots.style import (
    COLOURS,
    EDGE,
    LINE,
    PROPOSED,
    PUBLISHED,
    QUANTITY_LABELS,
    decimal_ticks,
    new_figure,
    numeral,
    spaced_labels,
    styled,
)
from study.published_curves.recovery import EXCLUDED, INDISTINGUISHABLE

_SWEEPS = {
    "noise": "noise of a point [mm]",
    "poses": "poses on all planes",
    "points": "points a scan",
    "plane_offset": "offset of the initial planes [mm]",
    "plane_tilt": "tilt of the initial planes [°]",
}
_STATED = "stated"
_SHOWN = 2  # explanations besides the stated noise; with more, the bands hide one another
_LOOKS = ((COLOURS["first explanation"], "-"), (COLOURS["second explanation"], "--"))
# The curves of the maxima look the same; predictions.csv has them.
_SIZE_UNITS = {
    "mrad": ("°", MRAD / DEG),
    "factor": (" × σ", 1.0),
    "share": (" σ", 1.0),
    "relative": (" tolerance", 1.0),
    "count": (" iterations", 1.0),
}
"""``{unit of a magnitude in the table: (what follows its number, factor to it)}``; angles are degrees in every figure."""
_QUANTITIES = ("position_mean_mm", "orientation_mean_deg")
_NEAR = 0.24  # share of a panel's width: labels of ticks nearer than this to one another are left out
_VERDICTS = {
    "supported": COLOURS["first explanation"],
    "disfavoured": COLOURS["second explanation"],
    "excluded": EDGE,
}
_MARKS = {"supported": "o", "disfavoured": "D", "excluded": "X"}
_FARTHEST = 300.0  # nats; a candidate that lies farther behind the best is drawn at this value


def draw_curves(candidates: pd.DataFrame, predictions: pd.DataFrame) -> Figure:
    """Return the published points and the predictions of the stated noise and of the best explanations.

    Args:
        candidates: candidates.csv.
        predictions: predictions.csv.
    """
    tested: Any = candidates[candidates["verdict"] != "not_tested"]
    ranked = tested.sort_values("behind")
    names = [name for name in ranked["candidate"] if name != _STATED][:_SHOWN]
    labels = dict(zip(ranked["candidate"], ranked["label"], strict=True))
    table: Any = predictions
    sweeps = [name for name in _SWEEPS if name in set(table["sweep"])]
    looks: Any = _LOOKS
    with styled():
        figure = new_figure(1.84 * max(len(sweeps), 3), 4.6)
        axes = np.atleast_2d(figure.subplots(len(_QUANTITIES), len(sweeps), sharey="row", squeeze=False))
        for row, quantity in zip(axes, _QUANTITIES, strict=True):
            for ax, sweep in zip(row, sweeps, strict=True):
                here = table[(table["sweep"] == sweep) & (table["quantity"] == quantity)]
                _panel(ax, here, names, sweep)
            row[0].set_ylabel(QUANTITY_LABELS[quantity])
        for ax, sweep in zip(axes[-1], sweeps, strict=True):
            ax.set_xlabel(_SWEEPS[sweep].replace(" of ", "\nof ").replace(" on ", "\non "))
        handles: list[Any] = [
            Line2D([], [], marker="o", linestyle="", color=PUBLISHED, label="published, one run a point")
        ]
        handles.append(
            Line2D([], [], color=PROPOSED, linestyle=":", label="stated noise alone, our workcell")
        )
        for name, (colour, line) in zip(names, looks, strict=False):
            handles.append(Line2D([], [], color=colour, linestyle=line, linewidth=1.8, label=labels[name]))
        figure.legend(handles=handles, loc="outside upper center", ncols=3)
    return figure


def _panel(ax: Axes, table: Any, names: list[str], sweep: str) -> None:
    """Draw the published values of one sweep and quantity, and what the stated noise and the named explanations predict."""
    stated = table[table["candidate"] == _STATED].sort_values("value")
    x = stated["value"].to_numpy(dtype=float)
    ax.plot(x, stated["without_offset"], ":", color=PROPOSED, linewidth=1.8)
    for name, (colour, line) in zip(names, _LOOKS, strict=False):
        mine = table[table["candidate"] == name].sort_values("value")
        ax.fill_between(x, mine["p05"], mine["p95"], color=colour, alpha=0.12, linewidth=0)
        ax.plot(x, mine["median"], line, color=colour, linewidth=1.6)
    ax.plot(x, stated["published"], "o", color=PUBLISHED, markersize=4.5, markeredgecolor="white")
    ax.set_yscale("log")
    decimal_ticks(ax.yaxis)
    ax.set_xscale("linear" if sweep == "plane_tilt" else "log")
    at = x if sweep == "plane_tilt" else np.log(x)
    places = (at - at.min()) / (np.ptp(at) or 1.0)
    ax.set_xticks(x, spaced_labels(list(places), [numeral(value) for value in x], _NEAR), fontsize=8)
    ax.xaxis.set_minor_locator(NullLocator())


def draw_support(candidates: pd.DataFrame) -> Figure:
    """Return a figure of how far each candidate lies behind the best by every way of weighing, with its magnitudes and misfit.

    Args:
        candidates: candidates.csv.
    """
    table: Any = candidates[candidates["verdict"] != "not_tested"]
    table = table.sort_values("behind", ascending=False)
    rows = table.to_dict("records")
    ways = [
        name
        for name in table.columns
        if name.startswith("behind_") and name not in ("behind_least", "behind_most")
    ]
    with styled():
        figure = new_figure(11.4, 0.34 * len(rows) + 1.8)
        ax, words = figure.subplots(1, 2, sharey=True, width_ratios=[5.0, 5.2])
        words.axis("off")
        top = len(rows) - 0.35
        for x, text in ((0.0, "magnitudes (95 %)"), (0.89, "misfit: plain, with offset")):
            words.text(x, top, text, fontsize=8, fontweight="bold", ha="left" if x == 0 else "center")
        for at, row in enumerate(rows):
            colour, mark = _VERDICTS[row["verdict"]], _MARKS[row["verdict"]]
            others = np.minimum([row[way] for way in ways], _FARTHEST)
            ax.plot([others.min(), others.max()], [at, at], color=colour, linewidth=1.2, alpha=0.7)
            ax.plot(others, np.full(len(ways), at), "|", color=colour, markersize=8)
            ax.plot(
                min(row["behind"], _FARTHEST), at, mark, color=colour, markersize=8, markeredgecolor="white"
            )
            words.text(0.0, at, _magnitudes(row), va="center", fontsize=8)
            for x, name in ((0.84, "misfit_factor"), (0.94, "misfit_factor_with_offset")):
                words.text(x, at, f"{row[name]:.2f}", va="center", ha="center", fontsize=8)
        words.set_xlim(0.0, 1.0)
        for limit, text, side in (
            (INDISTINGUISHABLE, "indistinguishable ", "right"),
            (EXCLUDED, f" factor {np.exp(EXCLUDED):.0f}", "left"),
        ):
            ax.axvline(limit, color=LINE, linestyle="--", linewidth=0.9)
            ax.text(limit, top, text, fontsize=7.5, ha=side)
        ax.set_xscale("symlog", linthresh=3.0)
        ax.set_xlim(-0.4, _FARTHEST * 1.15)
        ax.set_xticks([0, 1, 3, 10, 30, 100, 300], ["0", "1", "3", "10", "30", "100", "≥ 300"])
        ax.xaxis.set_minor_locator(NullLocator())
        ax.set_ylim(-0.7, len(rows) + 0.1)
        ax.set_yticks(range(len(rows)), [row["label"] for row in rows])
        ax.set_xlabel("behind the best: difference of the logarithm of the evidence")
        handles = [
            Line2D([], [], marker=_MARKS[name], linestyle="", color=colour, label=name)
            for name, colour in _VERDICTS.items()
        ]
        handles.append(
            Line2D([], [], marker="|", linestyle="", color=EDGE, label="under another way of weighing")
        )
        figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _magnitudes(row: dict[str, Any]) -> str:
    """Return the fitted magnitudes of a candidate with their intervals, in words."""
    words = []
    for k in (1, 2):
        if isinstance(row.get(f"magnitude_{k}"), str):
            unit, factor = _SIZE_UNITS.get(row[f"unit_{k}"], (f" {row[f'unit_{k}']}".rstrip(), 1.0))
            value, low, high = (numeral(factor * row[f"{name}_{k}"], 2) for name in ("value", "low", "high"))
            words.append(f"{value}{unit} ({low}–{high})")
    return ", ".join(words)


def draw_recovery(candidates: pd.DataFrame, recovery: pd.DataFrame) -> Figure:
    """Return a figure of the confusion: how often each tried candidate is indistinguishable from the best, a row for each injected one.

    Args:
        candidates: candidates.csv.
        recovery: recovery.csv.
    """
    table: Any = recovery
    names = list(dict.fromkeys(table["injected"]))
    labels = dict(zip(candidates["candidate"], candidates["label"], strict=True))
    shares = (
        table.pivot(index="injected", columns="tried", values="indistinguishable")
        .loc[names, names]
        .to_numpy()
    )
    with styled():
        figure = new_figure(9.2, 0.38 * len(names) + 3.4)
        ax = figure.subplots()
        ax.imshow(shares, cmap="Greys", vmin=0.0, vmax=1.3, aspect="auto")
        for i in range(len(names)):
            for k in range(len(names)):
                share = shares[i, k]
                if share > 0:
                    weight: Any = {"fontweight": "bold" if i == k else "normal"}
                    colour = "white" if share > 0.7 else "black"
                    ax.text(
                        k,
                        i,
                        f"{100 * share:.0f}",
                        ha="center",
                        va="center",
                        fontsize=8,
                        color=colour,
                        **weight,
                    )
        ax.set_xticks(range(len(names)), names, rotation=55, ha="right", rotation_mode="anchor")
        ax.set_yticks(range(len(names)), [labels[name] for name in names])
        ax.grid(visible=False)
        ax.set_xlabel("tried: indistinguishable from the best, in per cent of the sets")
        ax.set_ylabel("injected")
    return figure
