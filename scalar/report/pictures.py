"""Draw the profiles and maps of effects: each twice, without and with the effect in the model, in the same axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from scalar.effects.picture import Axis, Map, Profile
from scalar.geometry.se3 import Array
from scalar.report.axes import dot_titles, in_words, range_of, shown, with_unit
from scalar.report.panel import Panel
from scalar.report.thinning import in_caption, thinned

_SHOWN = 0.985  # share of the values within the axes; the others are drawn at their edge
# A pose whose standard error is more than this many times the median hardly shows the effect, and is left out.
_UNSURE = 3.0
_LEAST_PER_BIN = 4  # poses in a group of neighbours whose mean is drawn
_MOST_BINS = 72  # groups of neighbours
_LARGEST_MARK = 13.0  # points across, on a map
_MANY_MARKS = 500  # from here on a map's marks are smaller
TITLES = ("without the effect", "with the effect")


@dataclass(frozen=True)
class Pair:
    """Two pictures in the same axes, and how to read them.

    Attributes:
        before, after: The pictures without and with the effect; ``after`` is None if there is nothing to compare.
        caption: A few sentences.
        key: The legend: sign, colour and meaning of each kind of mark.
    """

    before: Markup
    after: Markup | None
    caption: str
    key: tuple[tuple[str, str, str], ...] = ()


def draw(trace: Profile | Map, poses: Array, most: int) -> Pair:
    """Return the pictures of a profile or a map without and with its effect.

    Args:
        trace: The profile or map.
        poses: ``(N,)``, the identifiers of the dataset's poses.
        most: The most dots that a panel may have.
    """
    return _draw_map(trace, poses, most) if isinstance(trace, Map) else _draw_profile(trace, poses, most)


def panel_of(
    x: Axis, y: Axis, x_range: tuple[float, float], y_range: tuple[float, float], title: str
) -> Panel:
    """Return an empty panel.

    Args:
        x: The horizontal axis.
        y: The vertical axis.
        x_range: Least and largest value on the horizontal axis, in the unit in which it is shown.
        y_range: The same for the vertical axis.
        title: The heading.
    """
    return Panel(
        x_range,
        y_range,
        title=title,
        x_label=in_words(x),
        y_label=in_words(y),
        x_is_angle=x.unit == "rad",
    )


def sentences(*parts: str) -> str:
    """Return the parts of a caption that are not empty, one after another; the first with a capital."""
    text = " ".join(part for part in parts if part)
    return text[:1].upper() + text[1:]


def at_the_edge(count: int) -> str:
    """Return the sentence on values that lie beyond the axes; empty where there are none."""
    if not count:
        return ""
    return f"Hollow marks at the edge: {count} value{'' if count == 1 else 's'} beyond the axes."


def _draw_profile(profile: Profile, poses: Array, most: int) -> Pair:
    sure = profile.std <= _UNSURE * np.nanmedian(profile.std)
    x, y = shown(profile.x_axis, profile.x[sure]), shown(profile.y_axis, profile.y[sure])
    rest, std = shown(profile.y_axis, profile.rest[sure]), shown(profile.y_axis, profile.std[sure])
    fitted = shown(profile.y_axis, profile.fitted[sure])
    side = None if profile.side is None else profile.side[sure]
    identifiers = (poses if profile.pose is None else poses[profile.pose])[sure]
    curve = None
    if profile.curve is not None:
        scale = shown(profile.y_axis, profile.curve[1:])
        curve = np.stack([shown(profile.x_axis, profile.curve[0]), *scale])
    low, high = range_of([y, rest], _SHOWN)
    low2, high2 = range_of([fitted] if curve is None else [curve[1] + curve[2], curve[1] - curve[2]])
    y_range, x_range = (min(low, low2), max(high, high2)), range_of([x])
    if curve is not None and profile.x_axis.unit == "rad" and "within" in profile.x_axis.label:
        x_range = (0.0, float(curve[0, -1]))
    bins = _bins(x, side, curve, profile.mark)
    some = thinned(rest / std, most)
    panels, beyond = [], 0
    for title, values in zip(TITLES, (y, rest), strict=True):
        panel = panel_of(profile.x_axis, profile.y_axis, x_range, y_range, title)
        said = dot_titles(identifiers[some], [(profile.x_axis, x[some])], profile.y_axis, values[some])
        beyond += _draw_values(panel, x[some], values[some], said, None if side is None else side[some])
        if values is y:
            _draw_fit(panel, x[some], fitted[some], None if side is None else side[some], curve, bool(bins))
        for group in bins:
            panel.bars(*_means(x, values, std, group), "ink")
        if profile.mark is not None:
            panel.moment(float(profile.mark), f"from order {profile.mark:.0f} on")
        panels.append(panel)
    what = f"{profile.y_axis.label} against {profile.x_axis.label}"
    left_out = int(np.count_nonzero(~sure))
    return Pair(
        panels[0].markup(f"{what}, without the effect"),
        panels[1].markup(f"{what}, with the effect: what remains"),
        sentences(
            f"{what}.",
            profile.note,
            _left_out(left_out),
            in_caption(int(some.sum()), len(some)),
            at_the_edge(beyond),
        ),
        _key(side is not None, curve is not None, bool(bins)),
    )


def _left_out(count: int) -> str:
    """Return the sentence on measurements that are not drawn; empty where all are."""
    if not count:
        return ""
    return f"{'1 measurement' if count == 1 else f'{count} measurements'} that can hardly show the effect {'is' if count == 1 else 'are'} not drawn."


def _key(has_sides: bool, has_curve: bool, has_means: bool) -> tuple[tuple[str, str, str], ...]:
    key = [("●", "dot", "one measurement")]
    if has_sides:
        key = [("▲", "orange", "side +"), ("▼", "blue", "side −")]
    line = ("━", "orange", "fitted effect") if has_curve or has_sides else ("□", "orange", "fitted effect")
    return (*key, line, *([("●", "ink", "mean of neighbours ± its standard error")] if has_means else []))


def _draw_values(panel: Panel, x: Array, y: Array, said: list[str], side: Array | None) -> int:
    """Draw the value of each pose, with a mark of its own for each side; return how many lie beyond the axes."""
    if side is None:
        return panel.marks(x, y, said, "dot", alpha=0.62)
    beyond = 0
    for marker, colour, group in (("v", "blue", side < 0), ("^", "orange", side > 0)):
        chosen = [said[i] for i in np.flatnonzero(group)]
        beyond += panel.marks(x[group], y[group], chosen, colour, marker=marker, size=5.5, alpha=0.42)
    return beyond


def _draw_fit(
    panel: Panel, x: Array, fitted: Array, side: Array | None, curve: Array | None, bold: bool
) -> None:
    """Draw an effect: its curve, or a level for each side, or a mark for each pose."""
    if curve is not None:
        panel.band(curve[0], curve[1] - 2 * curve[2], curve[1] + 2 * curve[2], "orange")
        panel.line(curve[0], curve[1], "orange", behind=not bold)
    elif side is None:
        panel.marks(x, fitted, None, "orange", marker="s", size=5.0, hollow=True)
    else:
        for s in (-1, 1):
            if np.any(side == s):
                panel.line(np.array(panel.x_range), np.full(2, np.mean(fitted[side == s])), "orange")


def _bins(x: Array, side: Array | None, curve: Array | None, mark: float | None) -> list[list[Array]]:
    """Return groups of neighbours in x, for means: narrow enough to follow the curve and with enough poses each; else none."""
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
    """Return the weighted means of x and y of every group, and the standard error of that of y from the group's scatter."""
    weights = [1.0 / std[g] ** 2 for g in groups]
    centre = np.array([np.average(x[g], weights=w) for g, w in zip(groups, weights, strict=True)])
    mean = np.array([np.average(y[g], weights=w) for g, w in zip(groups, weights, strict=True)])
    scatter = [np.average((y[g] - m) ** 2, weights=w) for g, w, m in zip(groups, weights, mean, strict=True)]
    # The effective number of poses, for weights that differ.
    number = np.array([w.sum() ** 2 / np.sum(w * w) for w in weights])
    return centre, mean, np.sqrt(np.array(scatter) / np.maximum(number - 1.0, 1.0))


def _draw_map(trace: Map, poses: Array, most: int) -> Pair:
    u, v = shown(trace.u_axis, trace.u), shown(trace.v_axis, trace.v)
    y, rest = shown(trace.y_axis, trace.y), shown(trace.y_axis, trace.rest)
    largest = max(float(np.quantile(np.abs(y), 0.98)), 1e-12)
    width = _LARGEST_MARK if len(u) < _MANY_MARKS else _LARGEST_MARK * 0.75
    some = thinned(np.maximum(np.abs(y), np.abs(rest)), most)
    panels = []
    for title, values in zip(TITLES, (y, rest), strict=True):
        panel = panel_of(trace.u_axis, trace.v_axis, range_of([u]), range_of([v]), title)
        size = width * np.sqrt(np.minimum(np.abs(values) / largest, 1.2))
        for marker, colour, sign in (("v", "blue", values < 0), ("^", "orange", values >= 0)):
            group = some & sign
            where = [(trace.u_axis, u[group]), (trace.v_axis, v[group])]
            said = dot_titles(poses[trace.pose[group]], where, trace.y_axis, values[group])
            panel.marks(u[group], v[group], said, colour, marker=marker, size=size[group], alpha=0.7)
        panels.append(panel)
    what = f"{trace.y_axis.label} over {trace.u_axis.label} and {trace.v_axis.label}"
    return Pair(
        panels[0].markup(f"{what}, without the effect"),
        panels[1].markup(f"{what}, with the effect: what remains"),
        sentences(
            f"{what}.",
            f"The larger the area, the larger the value; the largest are {with_unit(trace.y_axis, largest, 2)}.",
            trace.note,
            in_caption(int(some.sum()), len(some)),
        ),
        (("▲", "orange", "above zero"), ("▼", "blue", "below zero")),
    )
