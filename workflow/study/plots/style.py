"""One look for all figures: colours that the colour-blind tell apart, a marker each for grey paper."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from scalar.data.io.atomic import atomic_write


@dataclass(frozen=True)
class Look:
    """How a method is drawn: its name in legends, a colour (Okabe and Ito's), a marker."""

    label: str
    colour: str
    marker: str


LOOKS = {
    "initial": Look("initial model", "#7f7f7f", "D"),
    "baseline-abs": Look("baseline, √|·|", "#d55e00", "^"),
    "baseline-abs-2018": Look("baseline, √|·|, lmfit of 2018", "#009e73", "P"),
    "baseline-clip": Look("baseline, √max(0, ·)", "#e69f00", "v"),
    "baseline-raise": Look("baseline, √ as it is", "#cc79a7", "s"),
    "proposed": Look("proposed method", "#0072b2", "o"),
}
"""The argument of the root in the baseline may become negative; the name says what is done then."""

PAGE_IN, COLUMN_IN = 6.93, 3.33
"""Width of a figure of the paper over the page, and in one of its columns."""

PUBLISHED_COLOUR = "#000000"

QUANTITY_LABELS = {
    "position_mean_mm": "mean position error [mm]",
    "position_max_mm": "maximum position error [mm]",
    "orientation_mean_deg": "mean orientation error [°]",
    "orientation_max_deg": "maximum orientation error [°]",
}

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
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "scalar",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
}
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": "scalar"},
    ".pdf": {"CreationDate": None, "Creator": "scalar", "Producer": "scalar"},
}
"""Without dates and versions, so that the same numbers give the same file."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the project's style, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure of a size in inches, its parts kept from overlapping."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


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
    """Return a number for a label: ``digits`` significant ones, no exponent where it can be read without."""
    return f"{value:.{digits}g}" if 1e-4 <= abs(value) < 1e5 or value == 0 else f"{value:.{digits - 1}e}"
