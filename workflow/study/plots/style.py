"""The common style of all figures: colours with one meaning each, markers that distinguish methods in grey prints, symbols of parameters."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from scalar.data.io.atomic import atomic_write


@dataclass(frozen=True)
class Look:
    """How a method is drawn: its name in legends, its colour and its marker."""

    label: str
    colour: str
    marker: str


COLOURS = {
    "proposed": "#0072b2",  # the proposed method, and the answers of the diagnosis
    "proposed-tolerance": "#56b4e9",
    "published": "#000000",
    "initial": "#7f7f7f",
    "baseline-abs": "#d55e00",
    "baseline-abs-2018": "#009e73",
    "baseline-clip": "#e69f00",
    "baseline-raise": "#cc79a7",
    "scanner first": "#882255",
    "arm first": "#999933",
    "arm first, linear": "#88ccee",
    "first explanation": "#332288",
    "second explanation": "#cc6677",
    "first campaign": "#8c510a",
    "second campaign": "#35978f",
    "third campaign": "#c51b7d",
    "floor": "#4d4d4d",
    "first wall": "#6b8cae",
    "second wall": "#b08d57",
    "another name": "#9ecae1",
    "wrong target": "#dfc27d",
    "wrong name": "#a50f15",
    "unattributed": "#9e9ac8",
    "unobservable": "#999999",
    "nothing": "#eeeeee",
}
"""``{meaning: colour}``; no colour has two meanings. Those of the methods are from the palette of Okabe and Ito."""
PROPOSED, PUBLISHED = COLOURS["proposed"], COLOURS["published"]
PROPOSED_LIGHT, PROPOSED_DARK = "#c6dbef", "#08306b"
"""Lighter and darker shades of ``PROPOSED``, for further things of the proposed method."""
LINE, EDGE, FAINT, GRID = "#000000", "#444444", "#bbbbbb", "#dddddd"
"""Colours without a meaning: axes and limits, edges of bars, lines between dots, grids."""
BAND = "#555555"
"""Colour of a band or a dot in a legend that explains those of all methods."""

LOOKS = {
    "initial": Look("initial model", COLOURS["initial"], "D"),
    "baseline-abs": Look("baseline, √|·|", COLOURS["baseline-abs"], "^"),
    "baseline-abs-2018": Look("baseline, √|·|, lmfit of 2018", COLOURS["baseline-abs-2018"], "P"),
    "baseline-clip": Look("baseline, √max(0, ·)", COLOURS["baseline-clip"], "v"),
    "baseline-raise": Look("baseline, √ as it is", COLOURS["baseline-raise"], "s"),
    "proposed": Look("proposed method", PROPOSED, "o"),
    "proposed-tolerance": Look("proposed method, tolerance stated", COLOURS["proposed-tolerance"], "X"),
}
"""``{method: look}``; a label of the baseline says what is done if the argument of its root is negative."""

PAGE_IN, COLUMN_IN = 6.93, 3.33
"""Width [in] of a figure of the paper that is as wide as the page, and of one in a column."""

QUANTITY_LABELS = {
    "position_mean_mm": "mean position error [mm]",
    "position_max_mm": "maximum position error [mm]",
    "orientation_mean_deg": "mean orientation error [°]",
    "orientation_max_deg": "maximum orientation error [°]",
}
QUANTITY_PANELS = (
    ("position_mean_mm", "position_max_mm"),
    ("orientation_mean_deg", "orientation_max_deg"),
)
"""The quantities in two rows of panels."""

_RC: Any = {
    "figure.dpi": 100,
    "savefig.dpi": 160,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same letters on every machine
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "scalar",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
}
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": "scalar"},
    ".pdf": {"CreationDate": None, "Creator": "scalar", "Producer": "scalar"},
}
"""Metadata of files by suffix, without dates and versions, so that the same numbers give the same file."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the project's style, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure of a size in inches, whose layout keeps its parts from overlapping."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def decimal_ticks(axis: Axis) -> None:
    """Label the decades of a logarithmic axis as decimal numbers, ``0.01``: an exponent would be too small to read in print."""
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def name_case(figure: Figure, case: str) -> None:
    """Write below a figure which case of the study it shows."""
    figure.supxlabel(f"case {case}", fontsize="medium", fontweight="bold")


def save_figure(figure: Figure, paths: Sequence[str | Path]) -> None:
    """Write a figure to each path, in the format of its suffix: .png, .svg or .pdf; whole or not at all."""
    with mpl.rc_context(_RC):
        for path in map(Path, paths):
            with atomic_write(path) as temporary:
                figure.savefig(temporary, format=path.suffix[1:], metadata=_METADATA[path.suffix])


def with_unit(value: float, column: str, digits: int = 3) -> str:
    """Return a number with the unit in its column's name: ``14.6 mm``, ``4.05°``."""
    return numeral(value, digits) + (" mm" if column.endswith("_mm") else "°")


def numeral(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits; with an exponent only if it is below 1e-4 or at least 1e5."""
    return f"{value:.{digits}g}" if 1e-4 <= abs(value) < 1e5 or value == 0 else f"{value:.{digits - 1}e}"


def rounded(value: float, digits: int) -> str:
    """Return a result with so many significant digits, also if the last of them are zeros: ``0.030``; large ones as whole numbers."""
    if not 1e-4 <= abs(value) < 1e5:
        return numeral(value, digits)
    return f"{value:#.{digits}g}".removesuffix(".") if abs(value) < 10**digits else f"{value:.0f}"


_GREEK = {"alpha": r"\alpha", "theta": r"\theta", "beta": r"\beta", "a": "a", "d": "d"}


def symbol(parameter: str) -> str:
    r"""Return the symbol of a parameter in the paper; a name without a symbol is returned as it is.

    ``alpha_4`` becomes ``\alpha_4``, ``sensor_x`` becomes ``x_s`` and ``sensor_rx`` becomes ``r_x`` (the scanner's position and rotation
    vector); ``normal_floor_u`` and ``distance_floor`` become ``u, floor`` and ``d, floor``.
    """
    if found := re.fullmatch(r"(a|d|alpha|theta|beta)_(\d+)", parameter):
        return f"${_GREEK[found[1]]}_{{{found[2]}}}$"
    if found := re.fullmatch(r"sensor_(r?)([xyz])", parameter):
        return f"$r_{{{found[2]}}}$" if found[1] else f"${found[2]}_{{s}}$"
    if found := re.fullmatch(r"normal_(\w+)_([uv])", parameter):
        return f"${found[2]}$, {plane_name(found[1])}"
    if found := re.fullmatch(r"distance_(\w+)", parameter):
        return f"$d$, {plane_name(found[1])}"
    return parameter


def plane_name(plane: str) -> str:
    """Return a target plane's name as a label."""
    return plane.replace("_", " ")


def spaced_labels(places: Sequence[float], labels: Sequence[str], least: float) -> list[str]:
    """Return the labels, those left blank that would be nearer than ``least`` to the one before or to the last; both ends are kept.

    Args:
        places: Positions of the labels along the axis, ascending, as shares of the axis' drawn length.
        labels: A label for each position.
        least: Least distance between two labels, as a share of the axis' length.
    """
    if not len(places):
        return []
    kept, last = [0], places[0]
    for i in range(1, len(places) - 1):
        if places[i] - last >= least and places[-1] - places[i] >= least:
            kept.append(i)
            last = places[i]
    kept.append(len(places) - 1)
    return [label if i in kept else "" for i, label in enumerate(labels)]
