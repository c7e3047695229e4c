"""One chart of the report, drawn by Matplotlib in the report's own style.

Matplotlib is imported here only, and this module only when a report is drawn. A chart does not depend on the
user's own settings of Matplotlib, and the same numbers give the same bytes.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from typing import Any

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullLocator, ScalarFormatter

from scalar.geometry.se3 import Array
from scalar.report.inline_svg import COLOURS, inlined, plain_text

WIDTH, HEIGHT = 400, 284  # points: the unit of the picture's own coordinates
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 12, 40, 40  # the least margins, in the same unit
_LETTER = 6.3  # width of a digit of a tick's label, in the same unit
_TALLEST = 1.5  # largest height over width of axes to scale; taller ones are made narrower
_TICKS = 5  # at most this many intervals between ticks
_WIDE_ANGLE = 20.0  # degrees: from this span on, ticks are at parts of a turn
_FEW_DECADES = 2.2  # up to this many decades, a logarithmic axis has three ticks in each
_SIZE_CLASSES = 8  # marks of different sizes are drawn in this many classes of size
_STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "scalar",
    "text.parse_math": False,  # names of a dataset's columns are text, whatever they hold
    "axes.unicode_minus": True,
}


class Panel:
    """Axes with things drawn on them, in the order of the calls."""

    def __init__(
        self,
        x_range: tuple[float, float],
        y_range: tuple[float, float],
        *,
        title: str,
        x_label: str,
        y_label: str,
        x_is_angle: bool = False,
        y_is_log: bool = False,
        to_scale: bool = False,
    ) -> None:
        """Make empty axes; ``to_scale`` draws a unit as long on both, and the picture's height follows."""
        self.y_range, self.x_range = y_range, x_range
        self._titles: dict[str, Sequence[str]] = {}
        with _style():
            self._figure = Figure()
            FigureCanvasSVG(self._figure)
            self._figure.patch.set_visible(False)
            ax = self._axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=x_range, ylim=y_range)
            if y_is_log:
                ax.set_yscale("log")
            ax.patch.set_visible(False)
            ax.spines[:].set_visible(False)
            ax.grid(color=_colour("grid"), linewidth=1)
            ax.set_axisbelow(True)
            ax.tick_params(length=0, pad=5, labelsize=10.5, labelcolor=_colour("soft"))
            _set_ticks(ax.xaxis, x_range, x_is_angle)
            # As much room as the longest label needs; the same for panels with the same range.
            labels = _set_log_ticks(ax.yaxis, y_range) if y_is_log else _set_ticks(ax.yaxis, y_range, False)
            left = max(_LEFT, _LETTER * max(map(len, labels)) + 12)
            self._axes_width = room = WIDTH - left - _RIGHT
            height = HEIGHT
            if to_scale:
                ratio = (y_range[1] - y_range[0]) / (x_range[1] - x_range[0])
                self._axes_width = room * min(1.0, _TALLEST / ratio)
                height = self._axes_width * ratio + _TOP + _BOTTOM
            left += (room - self._axes_width) / 2
            self._figure.set_size_inches(WIDTH / 72, height / 72)
            inner = (self._axes_width / WIDTH, 1.0 - (_BOTTOM + _TOP) / height)
            ax.set_position((left / WIDTH, _BOTTOM / height, *inner))
            if y_range[0] < 0 < y_range[1]:
                ax.axhline(0.0, color=_colour("zero"), linewidth=1, zorder=1)
            place = {"transform": None, "color": _colour("ink")}
            middle = left + self._axes_width / 2
            self._figure.text(middle, 8, plain_text(x_label), ha="center", fontsize=11.5, **place)
            self._figure.text(2, height - 13, plain_text(title), fontsize=12.5, weight="bold", **place)
            # Level, not turned: it is read on a phone as well, and has the whole width.
            self._figure.text(2, height - 29, plain_text(y_label), fontsize=11.5, **place)

    def points_across(self, width: float) -> float:
        """Return how many points across a length of the x axis is drawn."""
        return self._axes_width * width / (self.x_range[1] - self.x_range[0])

    def marks(
        self,
        x: Array,
        y: Array,
        titles: Sequence[str] | None,
        colour: str,
        *,
        marker: str = "o",
        size: float | Array = 4.0,
        alpha: float = 1.0,
        hollow: bool = False,
    ) -> int:
        """Draw a mark at each point; return how many lie beyond the axes.

        What lies beyond the axes is drawn at their edge, hollow, so that no outlier is lost.

        Args:
            x, y: ``(N,)``; what is not finite is left out.
            titles: What each mark says when it is pointed at, or None.
            colour: A name of ``COLOURS``.
            marker: As Matplotlib names it.
            size: Across, in points; one or ``(N,)``.
            alpha: Opacity.
            hollow: Draw the outline only.
        """
        finite = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        px, py = np.clip(x, *self.x_range), np.clip(y, *self.y_range)
        beyond = (px != x) | (py != y)
        sizes = np.broadcast_to(np.asarray(size, dtype=float), np.shape(x))
        step = float(np.max(sizes, initial=0.0)) / _SIZE_CLASSES
        classes = np.ceil(sizes / step - 1e-9) if step > 0 else np.zeros(np.shape(x))
        for outside, level in product((False, True), np.unique(classes)):
            chosen = finite[(beyond[finite] == outside) & (classes[finite] == level)]
            if not len(chosen):
                continue
            name = f"marks{len(self._titles)}"
            self._titles[name] = [titles[int(i)] for i in chosen] if titles is not None else []
            outline = hollow or outside or marker == "x"
            self._axes.plot(
                px[chosen],
                py[chosen],
                linestyle="none",
                marker=marker,
                markersize=level * step,
                markerfacecolor="none" if outline else _colour(colour),
                markeredgecolor=_colour(colour) if outline else "none",
                markeredgewidth=1.1 if outline else 0.0,
                alpha=alpha,
                clip_on=False,
                gid=name,
                zorder=2,
            )
        return int(np.count_nonzero(beyond[finite]))

    def line(self, x: Array, y: Array, colour: str, *, behind: bool = False) -> None:
        """Draw a line through points, cut at the axes; with ``behind`` it is thin and behind the marks."""
        width, height = (1.0, 1.5) if behind else (2.2, 3.0)
        self._axes.plot(x, y, color=_colour(colour), linewidth=width, zorder=height)

    def band(self, x: Array, low: Array, high: Array, colour: str) -> None:
        """Fill between two lines, cut at the axes."""
        self._axes.fill_between(x, low, high, color=_colour(colour), alpha=0.16, linewidth=0, zorder=3)

    def bars(self, x: Array, y: Array, error: Array, colour: str) -> None:
        """Draw error bars of one standard error, with a dot in the middle."""
        self._axes.errorbar(
            x,
            y,
            error,
            fmt="o",
            markersize=5.4,
            markeredgewidth=0,
            color=_colour(colour),
            elinewidth=1.3,
            zorder=4,
        )

    def moment(self, x: float, text: str) -> None:
        """Mark a value of x by a dashed line with a word."""
        self._axes.axvline(x, color=_colour("ink"), linewidth=1.2, dashes=(3.5, 2.5), zorder=3)
        low, high = self.x_range
        late = x > low + 0.6 * (high - low)
        self._axes.annotate(
            text,
            (x, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-4 if late else 4, -10),
            textcoords="offset points",
            ha="right" if late else "left",
            fontsize=10.5,
            color=_colour("soft"),
        )

    def steps(self, edges: Array, heights: Array, colour: str) -> None:
        """Draw a histogram."""
        self._axes.stairs(heights, edges, fill=True, color=_colour(colour))

    def markup(self, alt: str) -> Markup:
        """Return the picture as a part of the page.

        Args:
            alt: What it shows in words, for those who do not see it.
        """
        buffer = io.StringIO()
        with _style():
            self._figure.savefig(
                buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
            )
        return Markup(inlined(buffer.getvalue(), plain_text(alt), self._titles))


@contextmanager
def _style() -> Iterator[None]:
    # Neither the user's own settings nor another program's reach the report.
    settings: dict[Any, Any] = {**matplotlib.rcParamsDefault, **_STYLE}
    with matplotlib.rc_context(settings), warnings.catch_warnings():
        # The browser draws the letters, so it does not matter if Matplotlib's own font lacks one.
        warnings.filterwarnings("ignore", message="Glyph")
        yield


def _colour(name: str) -> str:
    return COLOURS[name][0]


def _set_log_ticks(axis: Any, span: tuple[float, float]) -> list[str]:
    """Set ticks at 1, 2 and 5 times powers of ten, or at the powers alone where there are many; return their labels."""
    decades = np.log10(span[1] / span[0])
    ticks = [
        step * 10.0**power
        for power in range(int(np.floor(np.log10(span[0]))), int(np.ceil(np.log10(span[1]))) + 1)
        for step in ((1.0, 2.0, 5.0) if decades < _FEW_DECADES else (1.0,))
    ]
    labels = [f"{tick:g}" for tick in ticks if span[0] <= tick <= span[1]]
    axis.set_major_locator(FixedLocator([float(label) for label in labels]))
    axis.set_major_formatter(FixedFormatter(labels))
    axis.set_minor_locator(NullLocator())
    return labels or [""]


def _set_ticks(axis: Any, span: tuple[float, float], is_angle: bool) -> list[str]:
    """Set round ticks, degrees in parts of a turn where there are many; return their labels."""
    turn = is_angle and span[1] - span[0] > _WIDE_ANGLE
    locator = MaxNLocator(_TICKS, steps=[1, 1.5, 3, 4.5, 6, 9, 10] if turn else [1, 2, 2.5, 5, 10])
    formatter = ScalarFormatter(useOffset=False)
    formatter.set_scientific(False)
    axis.set_major_locator(locator)
    axis.set_major_formatter(formatter)
    return formatter.format_ticks(list(locator.tick_values(*span)))
