"""From traces to pictures: each effect without it and with it, in the same axes, side by side where there
is room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.profiles import Axis, Map, Profile
from scalar.diagnosis.scan_residuals import signed_residual
from scalar.geometry.se3 import Array
from scalar.report.svg import Panel, range_of
from scalar.units import DEG, MM

_UNITS = {
    "rad": (DEG, "°"),
    "m": (MM, "mm"),
    "m/m": (MM, "mm per m"),
    "s": (1.0, "s"),
    "degC": (1.0, "°C"),
    "1": (1.0, ""),
    "": (1.0, ""),
}
_SHOWN = 0.985  # of the dots lie within the axes
_UNSURE = 3.0  # times the typical standard error: beyond it a pose says nothing of the effect and is left out
_LEAST_PER_BIN = 4
_MOST_BINS = 72
_MOST_DOTS = 800  # in a picture; means are taken of all
_LARGEST_MARK = 13.0


@dataclass(frozen=True)
class Pair:
    """Two pictures in the same axes, and how to read them.

    Attributes:
        before, after: Without and with what is shown; ``after`` is None where there is nothing to compare.
        caption: A few sentences.
        key: What the marks are: (class, words).
    """

    before: Markup
    after: Markup | None
    caption: str
    key: tuple[tuple[str, str], ...] = ()


def in_words(axis: Axis) -> str:
    """Return an axis label with its unit."""
    unit = _UNITS[axis.unit][1]
    return f"{axis.label} [{unit}]" if unit else axis.label


def shown(axis: Axis, values: Array) -> Array:
    """Return values in the unit that they are shown in."""
    return np.asarray(values, dtype=float) / _UNITS[axis.unit][0]


def draw(trace: Profile | Map) -> Pair:
    """Return a trace without and with its effect."""
    return _draw_map(trace) if isinstance(trace, Map) else _draw_course(trace)


def _draw_course(course: Profile) -> Pair:
    sure = course.std <= _UNSURE * np.nanmedian(course.std)
    x, y = shown(course.x_axis, course.x[sure]), shown(course.y_axis, course.y[sure])
    rest, std = shown(course.y_axis, course.rest[sure]), shown(course.y_axis, course.std[sure])
    fitted = shown(course.y_axis, course.fitted[sure])
    side = None if course.side is None else course.side[sure]
    curve = None
    if course.curve is not None:
        scale = shown(course.y_axis, course.curve[1:])
        curve = np.stack([shown(course.x_axis, course.curve[0]), *scale])
    drawn = [fitted] if curve is None else [curve[1] + curve[2], curve[1] - curve[2]]
    low, high = range_of([y, rest], _SHOWN)
    low2, high2 = range_of(drawn)
    y_range, x_range = (min(low, low2), max(high, high2)), range_of([x])
    if course.x_axis.unit == "rad" and "within" in course.x_axis.label:
        x_range = (0.0, float(curve[0, -1])) if curve is not None else x_range
    bins = _bins(x, side, curve, course.mark)
    some = _thinned(len(x))
    panels = []
    for title, values in (("without the effect", y), ("with the effect", rest)):
        panel = _panel(course.x_axis, course.y_axis, x_range, y_range, title)
        if values is y and curve is not None:
            panel.band(curve[0], curve[1] - 2 * curve[2], curve[1] + 2 * curve[2], "fit-band")
            panel.line(curve[0], curve[1], "fit")
        if side is None:
            panel.dots(x[some], values[some], "dot")
        else:
            for shape, css, group in (("down", "minus faint", side < 0), ("up", "plus faint", side > 0)):
                panel.marks(x[some & group], values[some & group], np.array(5.0), shape, css)
        if values is y and curve is None:
            _draw_fit(panel, x, fitted, side, some)
        for group in bins:
            panel.bars(*_means(x, values, std, group), "mean")
        if course.mark is not None:
            panel.moment(course.mark, f"from order {course.mark:.0f} on")
        panels.append(panel)
    what = f"{course.y_axis.label} against {course.x_axis.label}"
    key = [("dot", "what one pose asks for")] if side is None else [("plus", "side +"), ("minus", "side −")]
    key += [("fit" if curve is not None or side is not None else "fit-mark", "fitted effect")]
    key += [("mean", "mean of neighbours ± its standard error")] if bins else []
    left_out = int(np.count_nonzero(~sure))
    unsure = f" {_count(left_out)} that can hardly show it not drawn." if left_out else ""
    if len(x) > _MOST_DOTS:
        unsure += f" {_MOST_DOTS} of {len(x)} dots drawn."
    return Pair(
        panels[0].markup(f"{what}, without the effect"),
        panels[1].markup(f"{what}, with the effect: what remains"),
        f"{_sentence(what)}. {course.note}{unsure}".strip(),
        tuple(key),
    )


def _count(number: int) -> str:
    return "1 measurement" if number == 1 else f"{number} measurements"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _panel(x: Axis, y: Axis, x_range: tuple[float, float], y_range: tuple[float, float], title: str) -> Panel:
    return Panel(
        x_range,
        y_range,
        title=title,
        x_label=in_words(x),
        y_label=in_words(y),
        x_is_angle=x.unit == "rad",
    )


def _draw_fit(panel: Panel, x: Array, fitted: Array, side: Array | None, some: Array) -> None:
    """Draw an effect that is no function of x: a level for each side, or a mark for each pose."""
    if side is None:
        panel.marks(x[some], fitted[some], np.array(6.0), "square", "fit-mark")
        return
    for s in (-1, 1):
        if np.any(side == s):
            value = float(np.mean(fitted[side == s]))
            panel.line(np.array(panel.x_range), np.array([value, value]), "fit")


def _thinned(count: int) -> Array:
    """Return which of many poses to draw, so that the page stays small: evenly spread in order of
    acquisition."""
    some = np.zeros(count, dtype=bool)
    some[np.unique(np.linspace(0, count - 1, min(count, _MOST_DOTS)).astype(int))] = True
    return some


def _bins(x: Array, side: Array | None, curve: Array | None, mark: float | None) -> list[list[Array]]:
    """Return groups of neighbours in x: enough not to blur what is drawn, each large enough for a mean;
    else none."""
    if curve is None and side is None:
        return []
    turns = 0 if curve is None else int(np.count_nonzero(np.diff(np.sign(np.diff(curve[1])))))
    count = max(int(np.clip(len(x) // 12, 6, 16)), 4 * turns)
    if count > _MOST_BINS or len(x) // count < _LEAST_PER_BIN:
        return []
    parts = [np.ones(len(x), dtype=bool)]
    if side is not None:
        parts = [side < 0, side > 0]
    elif mark is not None:
        parts = [x < mark, x >= mark]
    per_bin = max(len(x) // count, _LEAST_PER_BIN)
    return [_equal_groups(x, np.flatnonzero(part), max(int(part.sum()) // per_bin, 1)) for part in parts]


def _equal_groups(x: Array, members: Array, count: int) -> list[Array]:
    members = members[np.argsort(x[members], kind="stable")]
    return [part for part in np.array_split(members, count) if len(part) >= _LEAST_PER_BIN - 1]


def _means(x: Array, y: Array, std: Array, groups: list[Array]) -> tuple[Array, Array, Array]:
    """Return the weighted mean of x and y of every group, and the standard error of y by its own scatter."""
    weights = [1.0 / std[g] ** 2 for g in groups]
    centre = np.array([np.average(x[g], weights=w) for g, w in zip(groups, weights, strict=True)])
    mean = np.array([np.average(y[g], weights=w) for g, w in zip(groups, weights, strict=True)])
    spread = [np.average((y[g] - m) ** 2, weights=w) for g, w, m in zip(groups, weights, mean, strict=True)]
    # The effective number of poses, for weights that differ.
    number = np.array([w.sum() ** 2 / np.sum(w * w) for w in weights])
    return centre, mean, np.sqrt(np.array(spread) / np.maximum(number - 1.0, 1.0))


def _draw_map(trace: Map) -> Pair:
    u, v = shown(trace.u_axis, trace.u), shown(trace.v_axis, trace.v)
    y, rest = shown(trace.y_axis, trace.y), shown(trace.y_axis, trace.rest)
    largest = max(float(np.quantile(np.abs(y), 0.98)), 1e-12)
    width = _LARGEST_MARK if len(u) < 500 else _LARGEST_MARK * 0.75
    some = _thinned(len(u))
    panels = []
    for title, values in (("without the effect", y), ("with the effect", rest)):
        panel = _panel(trace.u_axis, trace.v_axis, range_of([u]), range_of([v]), title)
        size = width * np.sqrt(np.minimum(np.abs(values) / largest, 1.2))
        for shape, css, group in (
            ("down", "minus", some & (values < 0)),
            ("up", "plus", some & (values >= 0)),
        ):
            panel.marks(u[group], v[group], size[group], shape, css)
        panels.append(panel)
    what = f"{trace.y_axis.label} over {trace.u_axis.label} and {trace.v_axis.label}"
    unit = _UNITS[trace.y_axis.unit][1]
    return Pair(
        panels[0].markup(f"{what}, without the effect"),
        panels[1].markup(f"{what}, with the effect: what remains"),
        f"{_sentence(what)}. The larger the area, the larger the value; the largest are {largest:.2g} "
        f"{unit}. {trace.note}",
        (("plus", "above zero"), ("minus", "below zero")),
    )


def draw_residuals(before: FittedState, after: FittedState) -> Pair:
    """Return the residual of every pose in order of acquisition, of two states, planes told apart."""
    order, mm = before.residuals.poses.order, Axis("residual", "m")
    tracked = before.dataset.sensor.kind == "tracker"
    values = [shown(mm, signed_residual(state)) for state in (before, after)]
    y_range, x_range = range_of(values, 1.0, around_zero=True), range_of([order])
    y_axis = Axis("distance to the tracked point" if tracked else "mean height of a scan over its plate", "m")
    if before.dataset.sensor.kind == "probe":
        y_axis = Axis("height of a contact over its plate", "m")
    index = before.dataset.plane_index
    some = _thinned(len(order))
    panels, key = [], []
    same = before.model.effects == after.model.effects
    for title, y in zip(("all poses" if same else "before", "after"), values, strict=True):
        panel = _panel(Axis("order of acquisition", ""), y_axis, x_range, y_range, title)
        if tracked:
            panel.dots(order[some], y[some], "dot strong")
        for i, k in enumerate(np.unique(index)):
            shape = ("up", "square", "down", "cross")[i % 4]
            if not tracked:
                mine = some & (index == k)
                panel.marks(order[mine], y[mine], np.array(5.0), shape, f"series s{i % 4}")
        panels.append(panel)
    if not tracked:
        key = [(f"k{i % 4}", before.dataset.planes[k].name) for i, k in enumerate(np.unique(index))]
    what = f"{y_axis.label} for every pose in order of acquisition"
    alts = [f"{what}, {when}" for when in ("before", "after")]
    return Pair(
        panels[0].markup(alts[0]),
        None if same else panels[1].markup(alts[1]),
        f"{_sentence(what)}, everything fitted.",
        tuple(key),
    )


def draw_spread(before: Array, after: Array) -> Pair:
    """Return histograms of the poses' residuals in standard deviations of the noise, without and with a
    noise effect.

    Args:
        before: ``(K,)``, in standard deviations of the noise within scans alone.
        after: ``(K,)``, in those of the noise with the effect.
    """
    reach = float(np.clip(np.quantile(np.abs(before), 0.995), 3.5, 12.0))
    edges = np.linspace(-reach, reach, 41)
    heights = [np.histogram(values, edges, density=True)[0] for values in (before, after)]
    top = 1.1 * max(0.4, *(float(h.max()) for h in heights))
    x = np.linspace(-reach, reach, 161)
    normal = np.exp(-x * x / 2) / np.sqrt(2 * np.pi)
    panels = []
    for title, h in zip(("without the effect", "with the effect"), heights, strict=True):
        panel = _panel(
            Axis("residual, standard deviations", ""), Axis("density", ""), (-reach, reach), (0.0, top), title
        )
        panel.steps(edges, h, "histogram")
        panel.line(x, normal, "fit")
        panels.append(panel)
    what = "How often a residual of what size occurs, in standard deviations of what the noise explains"
    return Pair(
        panels[0].markup(f"{what}: wider than the noise within scans"),
        panels[1].markup(f"{what}: with the noise effect"),
        f"{what}. Where the noise explains the residual, the bars follow the curve.",
        (("bar", "what was measured"), ("fit", "what the noise explains")),
    )
