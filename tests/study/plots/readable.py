"""What every figure has to satisfy, whatever it shows: text that can be read, and data that is not cut off.

A figure is laid out and measured as matplotlib would draw it; nothing here knows what a figure means.
"""

from __future__ import annotations

import itertools
import weakref
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.text import Text

LEAST_SIZE = 6.0
"""Size of the smallest text [pt]."""
ROUNDING = 0.05
"""Of a size that follows from two widths [pt]."""
SLACK = 1.0
"""How far boxes of text may reach into one another or over the edge [pt]: a box is larger than its letters."""


_RENDERERS: weakref.WeakKeyDictionary[Figure, Any] = weakref.WeakKeyDictionary()


def laid_out(figure: Figure) -> Any:
    """Return the renderer of a figure whose parts have their final places; a figure is laid out once."""
    if figure not in _RENDERERS:
        canvas = FigureCanvasAgg(figure)
        figure.draw_without_rendering()
        _RENDERERS[figure] = canvas.get_renderer()
    return _RENDERERS[figure]


def texts(figure: Figure) -> list[Text]:
    """Return every text of a figure that is drawn: not empty, not hidden, no label of a tick beyond the axis."""
    laid_out(figure)
    hidden = _never_drawn(figure)
    return [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip() and t not in hidden]


def words(figure: Figure) -> str:
    """Return all text of a figure in one line."""
    return " ".join(text.get_text() for text in texts(figure))


def _never_drawn(figure: Figure) -> set[Text]:
    """Return the labels of ticks that lie outside their axis, and all text of axes and axes' frames that are switched off."""
    hidden: set[Text] = set()
    for axes in figure.findobj(lambda artist: hasattr(artist, "get_xticklabels")):
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            margin = 1e-6 * (high - low)
            for tick in itertools.chain(axis.get_major_ticks(), axis.get_minor_ticks()):
                if not low - margin <= tick.get_loc() <= high + margin:
                    hidden.update({tick.label1, tick.label2})
            if not axes.axison or not axes.get_visible() or not axis.get_visible():
                hidden.update(axis.findobj(Text))
    return hidden


def boxes(figure: Figure) -> list[tuple[Text, np.ndarray]]:
    """Return each drawn text and the corners ``(4, 2)`` [pt] of its box, turned as the text is."""
    renderer = laid_out(figure)
    found = []
    for text in texts(figure):
        angle = np.deg2rad(text.get_rotation())
        upright = text.get_window_extent(renderer)
        corners = np.array(
            [
                [upright.x0, upright.y0],
                [upright.x1, upright.y0],
                [upright.x1, upright.y1],
                [upright.x0, upright.y1],
            ]
        )
        if abs(np.sin(2 * angle)) > 1e-6:
            # Of a turned text matplotlib gives the upright box around it: the text's own has its centre, and is
            # as wide and as high as the text would be if it were not turned.
            text.set_rotation(0.0)
            own = text.get_window_extent(renderer)
            text.set_rotation(np.rad2deg(angle))
            half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [own.width / 2, own.height / 2]
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            corners = corners.mean(axis=0) + half @ turn.T
        found.append((text, corners * 72.0 / figure.dpi))
    return found


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    """Return how far two convex boxes ``(4, 2)`` reach into one another, the least over the directions of their sides; <= 0: apart."""
    depths = []
    for corners in (a, b):
        for side in np.diff(corners[:3], axis=0):
            length = np.linalg.norm(side)
            if length > 0:
                across = side / length
                (p, q), (r, s) = ((np.min(c @ across), np.max(c @ across)) for c in (a, b))
                depths.append(min(q, s) - max(p, r))
    return float(min(depths))


def small_texts(figure: Figure, printed_in: float | None = None) -> list[str]:
    """Return what is written smaller than LEAST_SIZE, at the width at which the figure is printed [in]; None: at its own."""
    own = float(figure.get_size_inches()[0])
    scale = 1.0 if printed_in is None else printed_in / own
    return [t.get_text() for t in texts(figure) if t.get_fontsize() * scale < LEAST_SIZE - ROUNDING]


def overlapping_texts(figure: Figure) -> list[tuple[str, str]]:
    """Return pairs of texts of which one stands on the other."""
    pairs = itertools.combinations(boxes(figure), 2)
    return [(a.get_text(), b.get_text()) for (a, p), (b, q) in pairs if overlap(p, q) > SLACK]


def texts_outside(figure: Figure) -> list[str]:
    """Return texts that reach over the edge of the figure."""
    size = figure.get_size_inches() * 72.0
    return [
        text.get_text() for text, box in boxes(figure) if np.any(box < -SLACK) or np.any(box > size + SLACK)
    ]


def data_outside(figure: Figure) -> list[tuple[str, float]]:
    """Return (label of the axis, share of the values outside) of everything drawn in coordinates of data whose values the axes cut off.

    Lines, dots and bars; a value that is not finite is a gap, and no value.
    """
    laid_out(figure)
    found = []
    for axes in figure.axes:
        x_limits, y_limits = np.sort(axes.get_xlim()), np.sort(axes.get_ylim())
        for label, values in _values(axes):
            values = values[np.isfinite(values).all(axis=1)]
            if not len(values):
                continue
            margin = 1e-9 * np.array([np.ptp(x_limits), np.ptp(y_limits)])
            low, high = (
                np.array([x_limits[0], y_limits[0]]) - margin,
                np.array([x_limits[1], y_limits[1]]) + margin,
            )
            cut = ((values < low) | (values > high)).any(axis=1)
            if cut.any():
                found.append((label, float(cut.mean())))
    return found


def _values(axes: Any) -> list[tuple[str, np.ndarray]]:
    """Return (label, points ``(n, 2)``) of all lines, dots and bars of axes in coordinates of data."""
    name = (
        " ".join(filter(None, [axes.get_title(), axes.get_xlabel(), axes.get_ylabel()]))
        or "axes without a label"
    )
    found = []
    for line in axes.lines:
        if line.get_transform().contains_branch(axes.transData) and line.get_clip_on():
            if line.get_transform() == axes.transData:
                found.append(
                    (name, np.column_stack([line.get_xdata(orig=False), line.get_ydata(orig=False)]))
                )
    for collection in axes.collections:
        if isinstance(collection, PathCollection):
            found.append((name, np.ma.filled(collection.get_offsets(), np.nan)))
    for patch in axes.patches:
        if hasattr(patch, "get_bbox") and patch.get_data_transform() == axes.transData:
            box = patch.get_bbox()
            found.append((name, np.array([[box.x0, box.y0], [box.x1, box.y1]])))
    return found


def assert_readable(figure: Figure, cut_off: float = 0.0, printed_in: float | None = None) -> None:
    """Fail with the words concerned if text is too small, stands on other text, is cut off by the edge, or data are cut off.

    Args:
        figure: What is judged.
        cut_off: Share of the values of one artist that the axes may cut off, where a figure says that it does so.
        printed_in: Width at which it stands in the paper [in]; None: it does not.
    """
    assert small_texts(figure, printed_in) == []
    assert overlapping_texts(figure) == []
    assert texts_outside(figure) == []
    assert [entry for entry in data_outside(figure) if entry[1] > cut_off] == []
