"""The figure of a diagnosis in five panels: residual, candidates, the joint's error by each pose, the remaining residual, errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.plots.style import COLOURS, EDGE, LINE, PROPOSED, new_figure, plane_name, rounded, styled

_MARKERS = ("^", "s", "v", "D", "P", "X")
_COLOURS = tuple(COLOURS[name] for name in ("floor", "first wall", "second wall"))
_SURE = 3.0  # times the median standard error; poses that determine the joint's error less well are left out of that panel
_SHOWN = 0.995  # share of the dots that lie within the axes


def draw_worked_example(
    poses: pd.DataFrame,
    curve: pd.DataFrame,
    ranking: pd.DataFrame,
    errors: pd.DataFrame,
    numbers: dict[str, Any],
) -> Figure:
    """Return the figure in five panels, to be read from the upper left.

    Args:
        poses: The table of this name that ``study.worked_example.tables.diagnosis_tables`` returns.
        curve: As ``poses``.
        ranking: As ``poses``.
        errors: As ``study.worked_example.tables.errors`` returns it.
        numbers: As ``study.worked_example.tables.numbers`` returns them.
    """
    joint = numbers["found"]["joint"]
    with styled():
        figure = new_figure(8.6, 5.4)
        halves: Any = figure.subfigures(2, 1)
        above, below = halves
        first, candidates = above.subplots(1, 2, width_ratios=[1.0, 1.1])
        asked, last, bars = below.subplots(1, 3, width_ratios=[1.0, 1.0, 1.45])
        top = (first, asked, last)
        limit = float(np.quantile(np.abs(poses["residual_before_mm"]), _SHOWN))
        for ax, when in ((top[0], "before"), (top[2], "after")):
            _residuals(ax, poses, when, limit)
            ax.set_xlabel(f"angle of joint {joint} [°]")
        top[0].set_title("1. the residual without an effect", fontsize=9)
        top[0].legend(loc="lower center", fontsize=7.5, ncols=3, columnspacing=0.8, handletextpad=0.2)
        _asked(top[1], poses, curve)
        top[1].set_xlabel(f"angle of joint {joint} [°]")
        top[1].set_ylabel(f"error of joint {joint} [°]")
        top[1].set_title(f"3. error of joint {joint} by each pose", fontsize=9)
        top[2].set_title("4. the residual with the effect", fontsize=9)
        _candidates(candidates, ranking)
        _errors(bars, errors, numbers)
    return figure


def _residuals(ax: Axes, poses: pd.DataFrame, when: str, limit: float) -> None:
    """Draw the mean height of every scan over its target plane."""
    for k, (plane, group) in enumerate(poses.groupby("plane", sort=True)):
        style: Any = {"markersize": 3.4, "linestyle": "none", "alpha": 0.8, "markeredgewidth": 0}
        look = {"marker": _MARKERS[k % len(_MARKERS)], "color": _COLOURS[k % len(_COLOURS)]}
        ax.plot(
            group["angle_deg"], group[f"residual_{when}_mm"], label=plane_name(str(plane)), **look, **style
        )
    ax.axhline(0.0, color=LINE, linewidth=0.7)
    ax.set_ylim(-1.25 * limit, 1.1 * limit)
    ax.set_ylabel("mean height of a scan\nover its target plane [mm]")


def _asked(ax: Axes, poses: pd.DataFrame, curve: pd.DataFrame) -> None:
    """Draw the joint's error by each pose (``asked_deg``), and the effect that was fitted."""
    std = poses["asked_std_deg"].to_numpy(dtype=float)
    sure: Any = poses[std <= _SURE * np.nanmedian(std)]
    ax.plot(
        sure["angle_deg"],
        sure["asked_deg"],
        "o",
        color=EDGE,
        markersize=3,
        markeredgewidth=0,
        alpha=0.75,
    )
    x, y = curve["angle_deg"].to_numpy(dtype=float), curve["effect_deg"].to_numpy(dtype=float)
    ax.plot(x, y, color=PROPOSED, linewidth=2.0)
    limit = float(np.quantile(np.abs(sure["asked_deg"]), _SHOWN))
    ax.set_ylim(-1.3 * limit, 1.3 * limit)
    ax.annotate("dots: poses; line: effect found", (0.03, 0.03), xycoords="axes fraction", fontsize=7.5)


def _candidates(ax: Axes, ranking: pd.DataFrame) -> None:
    """Draw the evidence of the best candidates on the residual before."""
    place = -np.arange(len(ranking))
    evidence = np.maximum(ranking["evidence_nats"].to_numpy(dtype=float), 0.0)
    found = ranking["found"].to_numpy(dtype=bool)
    colours = [PROPOSED if own else COLOURS["initial"] for own in found]
    ax.barh(place, evidence, color=colours, edgecolor=EDGE, linewidth=0.5, height=0.7)
    for y, value, share in zip(place, evidence, ranking["share_of_residual"], strict=True):
        ax.annotate(f" {value:.0f}  ({100 * share:.0f} %)", (value, y), va="center", fontsize=7.5)
    names = [plane_name(name[0].upper() + name[1:]) for name in ranking["candidate"]]
    ax.set_yticks(place, names, fontsize=7.5)
    ax.set_xlim(0, 1.5 * max(float(evidence.max()), 1.0))
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("log evidence (BIC) [nats], share of the residual", fontsize=9)
    ax.set_title("2. the best eight candidates", fontsize=9)


def _errors(ax: Axes, errors: pd.DataFrame, numbers: dict[str, Any]) -> None:
    """Draw held-out residuals and true errors: before, after, and at the noise floor."""
    by_when: Any = errors.set_index("when")
    held = numbers["held_out_rms_mm"]
    groups = [
        ("poses held out,\nRMS residual", [held["before"], held["after"], held["noise"]]),
        (
            f"{numbers['errors_over']:,} random poses,\nmean position error",
            [by_when.loc[when, "position_mean_mm"] for when in ("before", "after", "control")],
        ),
    ]
    labels = ("before", "after", "noise floor; matched control")
    for k, (label, colour, hatch) in enumerate(
        zip(labels, (COLOURS["initial"], PROPOSED, "white"), ("", "", "///"), strict=True)
    ):
        x = np.arange(len(groups)) + 0.26 * (k - 1)
        y = [values[k] for _, values in groups]
        ax.bar(x, y, 0.24, color=colour, edgecolor=EDGE, linewidth=0.6, hatch=hatch, label=label)
        for at, value in zip(x, y, strict=True):
            note: Any = {"xytext": (0, 2), "textcoords": "offset points", "ha": "center", "fontsize": 7.5}
            ax.annotate(rounded(float(value), 2), (at, value), **note)
    ax.set_xticks(range(len(groups)), [label for label, _ in groups], fontsize=8)
    ax.set_ylabel("[mm]")
    top = max(max(values) for _, values in groups)
    ax.set_ylim(0, 1.55 * top)
    ax.grid(visible=False, axis="x")
    ax.legend(loc="upper left", fontsize=7.5)
    ax.set_title("5. errors on poses not fitted", fontsize=9)
