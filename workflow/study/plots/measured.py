"""The figures of the measured robots: held-out errors of models with more and more parameters, and the errors of the gears over the joint angles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from scalar.units import DEG, MRAD
from study.plots.style import COLOURS, PROPOSED, PROPOSED_LIGHT, new_figure, numeral, styled

MODELS = (  # model in errors.csv, words, colour, hatch
    ("base_and_tool", "base and tool only", COLOURS["initial"], ""),
    ("geometry", "and the geometry", PROPOSED_LIGHT, "///"),
    ("geometry_and_effects", "and the effects found", PROPOSED, ""),
    ("effects_of", "another campaign's effects, fixed", COLOURS["second campaign"], "..."),
    ("effects_on_shuffled_angles", "control: angles of other poses", COLOURS["nothing"], "xxx"),
)
CAMPAIGNS = (
    ("first campaign", COLOURS["first campaign"], "-"),
    ("second campaign", COLOURS["second campaign"], "--"),
    ("third campaign", COLOURS["third campaign"], ":"),
)
_FAINT = 0.25  # opacity of a curve at angles without poses, and of bands


def set_words(name: str) -> str:
    """Return a set's name as a label."""
    return name.replace("_", " ").replace("ur10", "UR10").replace("motoman", "Motoman")


def draw_errors(errors: pd.DataFrame) -> Figure:
    """Return bars of the held-out error of every set and model.

    Args:
        errors: errors.csv of the measured summaries.
    """
    sets = list(dict.fromkeys(errors["set"]))
    with styled():
        figure = new_figure(max(7.4, 1.9 * len(sets)), 3.3)
        ax = figure.subplots()
        width = 0.8 / len(MODELS)
        for k, (model, label, colour, hatch) in enumerate(MODELS):
            of_model: Any = errors[
                errors["model"].str.startswith(model) & (errors["model"].eq(model) | (model == "effects_of"))
            ]
            places = np.array([sets.index(name) for name in of_model["set"]], dtype=float) + (k - 2) * width
            heights = of_model["held_out_rms_mm"].to_numpy(dtype=float)
            ax.bar(places, heights, width, label=label, color=colour, hatch=hatch, edgecolor="white")
            for x, height in zip(places, heights, strict=True):
                ax.annotate(numeral(height, 2), (x, height), ha="center", va="bottom", fontsize=7)
        ax.set_xticks(range(len(sets)), [set_words(name) for name in sets])
        ax.set_ylabel("error of held-out poses, RMS [mm]")
        ax.grid(axis="x", visible=False)
        ax.legend(fontsize=7.5)
    return figure


def draw_gears(gears: pd.DataFrame) -> Figure:
    """Return a figure with a panel for each joint: the error of its gear over its angle, as each campaign with errors in several joints found it.

    A curve is faint at angles without poses; at the others it has a band of twice its standard error.

    Args:
        gears: gears.csv of the measured summaries.
    """
    campaigns = [str(name) for name, rows in gears.groupby("set", sort=False) if len(set(rows["joint"])) > 1]
    shown: Any = gears[gears["set"].isin(campaigns)]
    joints = sorted(shown["joint"].unique())
    with styled():
        figure = new_figure(7.4, 0.9 + 0.78 * max(len(joints), 1))
        axes = figure.subplots(max(len(joints), 1), 1, sharex=True, squeeze=False)[:, 0]
        for ax, joint in zip(axes, joints, strict=False):
            for name, (label, colour, line) in zip(campaigns, CAMPAIGNS, strict=False):
                rows = shown[(shown["set"] == name) & (shown["joint"] == joint)]
                if not len(rows):
                    continue
                x, seen = rows["angle_deg"].to_numpy(), rows["seen"].to_numpy(dtype=bool)
                y = rows["error_mrad"].to_numpy() * (MRAD / DEG)
                y = y - (y[seen].mean() if seen.any() else 0.0)
                std = 2 * rows["std_mrad"].to_numpy() * (MRAD / DEG)
                ax.plot(x, y, line, color=colour, alpha=_FAINT, linewidth=0.8)
                ax.plot(x, np.where(seen, y, np.nan), line, color=colour, linewidth=1.3, label=label)
                ax.fill_between(x, y - std, y + std, where=seen, color=colour, alpha=_FAINT, linewidth=0)
                top = np.abs(y[seen]).max(initial=0.0)
                low, high = ax.get_ylim()
                ax.set_ylim(min(low, -1.2 * top), max(high, 1.2 * top))
            ax.set_ylabel(f"joint {joint}\n[°]")
        if len(joints):
            figure.legend(
                *axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=7.5
            )
        axes[-1].set_xlabel("joint angle [°]")
        axes[-1].set_xlim(-180, 180)
    return figure
