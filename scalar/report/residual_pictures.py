"""Pictures of residuals: the residual of every pose, and the distribution of residuals in standard deviations of their noise."""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.scan_residuals import signed_residual
from scalar.effects.picture import Axis
from scalar.geometry.se3 import Array
from scalar.report.axes import dot_titles, range_of, shown
from scalar.report.pictures import TITLES, Pair, panel_of, sentences
from scalar.report.thinning import in_caption, thinned
from scalar.sensors import kind_of

# The marks of planes: Matplotlib's name, and the sign in the legend.
_SHAPES = (("^", "△"), ("s", "□"), ("v", "▽"), ("x", "×"))
_SERIES = ("blue", "orange", "green", "purple")
_SMALLEST_REACH, _LARGEST_REACH = 3.5, 40.0  # half the width of a histogram, in standard deviations
_BINS = 60  # number of bins of a histogram


def draw_residuals(before: FittedState, after: FittedState, most: int) -> Pair:
    """Return the residual of every pose in order of acquisition, of two states; each plane has its own mark.

    Args:
        before: The fit without effects.
        after: The fit with the effects that were found.
        most: Largest number of dots in a panel.
    """
    dataset, order = before.dataset, before.residuals.poses.order
    values = [shown(Axis("residual", "m"), signed_residual(state)) for state in (before, after)]
    y_range, x_range = range_of(values, around_zero=True), range_of([order])
    x_axis = Axis("order of acquisition", "")
    y_axis = Axis(kind_of(dataset).residual_words, "m")
    identifiers = dataset.poses["pose"].to_numpy()
    index = dataset.plane_index if len(dataset.planes) else np.zeros(len(order), dtype=int)
    is_drawn = thinned(np.max(np.abs(values), axis=0), most)
    same = before.model.effects == after.model.effects
    panels, key = [], []
    for title, y in zip(("all poses" if same else "before", "after"), values, strict=True):
        panel = panel_of(x_axis, y_axis, x_range, y_range, title)
        for i, k in enumerate(np.unique(index)):
            on_plane = is_drawn & (index == k)
            titles = dot_titles(identifiers[on_plane], [(x_axis, order[on_plane])], y_axis, y[on_plane])
            (marker, sign), colour = _SHAPES[i % 4], _SERIES[(i + i // 4) % 4]
            if len(dataset.planes):
                panel.marks(
                    order[on_plane], y[on_plane], titles, colour, marker=marker, size=5.0, hollow=True
                )
                key += [(sign, colour, dataset.planes[k].name)] if y is values[0] else []
            else:
                panel.marks(order[on_plane], y[on_plane], titles, "dot", alpha=0.7)
        panels.append(panel)
    what = f"{y_axis.label} for every pose in order of acquisition"
    return Pair(
        panels[0].markup(f"{what}, before"),
        None if same else panels[1].markup(f"{what}, after"),
        sentences(f"{what}, with all parameters fitted.", in_caption(int(is_drawn.sum()), len(is_drawn))),
        tuple(key),
    )


def draw_scatter(before: Array, after: Array, random: bool) -> Pair:
    """Return histograms of the poses' residuals in standard deviations of the noise, without and with a
    variance component.

    Args:
        before: ``(K,)``, residuals in standard deviations of the noise within scans alone.
        after: ``(K,)``, residuals in standard deviations of the noise with the variance component.
        random: Whether the scatter is noise; if not, the caption says so.
    """
    reach = float(np.clip(np.quantile(np.abs(before), 0.98), _SMALLEST_REACH, _LARGEST_REACH))
    edges = np.linspace(-reach, reach, _BINS + 1)
    heights = [np.histogram(values, edges, density=True)[0] for values in (before, after)]
    beyond = int(np.count_nonzero(np.abs(before) > reach))
    top = 1.1 * max(0.4, *(float(h.max()) for h in heights))
    x = np.linspace(-reach, reach, 401)
    panels = []
    for title, h in zip(TITLES, heights, strict=True):
        x_axis, y_axis = Axis("residual, standard deviations", ""), Axis("density", "")
        panel = panel_of(x_axis, y_axis, (-reach, reach), (0.0, top), title)
        panel.steps(edges, h, "fill")
        panel.line(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), "orange")
        panels.append(panel)
    what = "how often residuals of each size occur, in standard deviations of the noise"
    return Pair(
        panels[0].markup(f"{what}: wider than the noise within scans"),
        panels[1].markup(f"{what}: with the variance component"),
        sentences(
            f"{what}.",
            "Where the noise explains the residual, the bars follow the curve.",
            f"Beyond the axes: {beyond} of {before.size} residuals without the effect." if beyond else "",
            "" if random else "The scatter is drawn here as though it were random, which it is not.",
        ),
        (("■", "fill", "what was measured"), ("━", "orange", "what the noise explains")),
    )
