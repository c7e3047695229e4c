"""The error of the arm over its workspace, by its data sheet and as calibrated: a table, two slices, and the error against the reach.

Random poses are sorted into square cells of a side view (distance from the first joint's axis, height) and of a view from above. A cell
shows the mean error over its poses, which have all orientations of the wrist.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.evaluate.workspace_errors import NOMINAL, Banded, errors_within_limits
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.report.panel import Panel
from scalar.report.pictures import Pair, sentences
from scalar.report.scale_words import scale_in_words
from scalar.report.words import number
from scalar.units import MM

WITHOUT_EFFECTS, SHIPPED = "before.json", "after.json"
_CELLS_ACROSS = 18
_LEAST_POSES = 3  # a cell with fewer poses is not drawn
_SHELLS = 12  # points of the curve over the distance from the first joint's axis
_DOTS = 150  # the most measured poses that are drawn
_STEPS = ((1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))  # edges of the colour classes in a decade, the finest first
_CLASSES = 9  # of colour
_LEVEL = 0.99  # cosine of the angle between two directions, above which they count as the same
_MOST = 0.95  # the table's upper bound holds for this share of the poses
_CELL_GAP = 0.6  # points
_LEAST_ERROR = 1e-9  # m: smaller errors are rounding, and no picture is drawn
_LEAST_SPAN = 1e-3  # m: the least width of a slice, which the poses of an arm of one joint may not fill


@dataclass(frozen=True, eq=False)
class Slice:
    """Where poses lie in one view of the workspace.

    Attributes:
        words: The direction of the view.
        labels: Labels of the two axes.
        at: ``(N, 2)`` [m], the random poses.
        measured: ``(M, 2)`` [m], the measured poses.
        from_axis: Whether the first coordinate is a distance from an axis, so that it begins at zero.
    """

    words: str
    labels: tuple[str, str]
    at: Array
    measured: Array
    from_axis: bool = False


def workspace_section(
    judged: Calibration, without_effects: Model | None, seen: Poses, file: str, lacking: float = 0.0
) -> dict[str, Any] | None:
    """Return the table and the pictures of the errors over the workspace, or None if there is no covariance, or no error.

    Args:
        judged: The calibration, with its covariance.
        without_effects: The model without effects, if it is another one; or None.
        seen: The measured poses.
        file: File name of the calibration, for the texts.
        lacking: Root mean square distance [m] by which the arm is off at every pose because of errors that the model does not contain.
    """
    robot = judged.model.nominal
    models = {**({} if without_effects is None else {WITHOUT_EFFECTS: without_effects}), file: judged.model}
    errors = errors_within_limits(judged, models, seen, lacking)
    if errors is None:
        return None
    sizes = {model: errors.sizes(model) for model in errors.errors}
    if max(float(draws.max()) for draws in sizes.values()) < _LEAST_ERROR:
        return None
    bases = EffectBases.of(robot, seen, judged.model.effects)
    measured = Kinematics.of(judged.model, seen, bases).T_base_sensor[:, :3, 3]
    side, top = _slices(robot, errors.position, measured)
    before, after = sizes[NOMINAL], sizes[file]
    cells = [Cells.of(view, before, after) for view in (side, top)]
    shades = np.concatenate([shade for one in cells for shade in one.shades])
    edges = _edges(float(shades.min()), float(shades.max()))
    pictures = [_draw_cells(one, edges, file) for one in cells]
    return {
        "rows": [
            {"state": model, "mean": _banded(Banded.of(draws.mean(axis=1))), "most": _banded(_bound(draws))}
            for model, draws in sizes.items()
        ],
        "poses": len(errors.position),
        "lacking": f"{number(lacking / MM)} mm" if lacking else "",
        "left_open": "",
        "scale": scale_in_words(judged),
        "pictures": [*pictures, _draw_reach(side, before, after, file)],
    }


def _bound(draws: Array) -> Banded:
    """Return the error that most poses do not exceed, from draws ``(R, N)`` [m]."""
    return Banded.of(np.quantile(draws, _MOST, axis=1))


def _banded(found: Banded) -> dict[str, str]:
    """Return the number and its band in millimetres, all with as many decimals as the number has."""
    value = number(found.value / MM)
    decimals = len(value.partition(".")[2])
    return {
        "value": f"{value} mm",
        "band": f"{found.low / MM:.{decimals}f} to {found.high / MM:.{decimals}f} mm",
    }


def _slices(robot: Robot, position: Array, measured: Array) -> tuple[Slice, Slice]:
    """Return the view from the side and the view from above."""
    up = -robot.down if robot.down.any() else np.array([0.0, 0.0, 1.0])
    level = abs(up[2]) > _LEVEL
    first = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < _LEVEL else np.array([0.0, 1.0, 0.0])
    first = first - up * (first @ up)
    first /= np.linalg.norm(first)
    second = np.cross(up, first) if up[2] >= 0 else np.cross(first, up)
    axis = robot.T_base_0[:3, 3]

    def seen(points: Array) -> tuple[Array, Array]:
        from_axis = points - axis
        across = from_axis - np.outer(from_axis @ up, up)
        side = np.column_stack([np.linalg.norm(across, axis=1), points @ up])
        return side, np.column_stack([points @ first, points @ second])

    (side, top), (side_measured, top_measured) = seen(position), seen(measured)
    names = ("x of the base [m]", "y of the base [m]") if level else ("horizontally [m]", "across that [m]")
    return (
        Slice(
            "from the side",
            (
                "horizontal distance from the first joint's axis [m]",
                "height above the base frame's origin [m]",
            ),
            side,
            side_measured,
            from_axis=True,
        ),
        Slice("from above", names, top, top_measured),
    )


@dataclass(frozen=True, eq=False)
class Cells:
    """A slice in square cells, with the errors in each.

    Attributes:
        view: The slice.
        centres: ``(C, 2)`` [m], centres of the cells that are drawn.
        width: Width of a cell [m].
        count: ``(C,)``, number of poses in each.
        found: Mean error of each cell [m] before and after, with its band.
    """

    view: Slice
    centres: Array
    width: float
    count: Array
    found: tuple[list[Banded], list[Banded]]

    @classmethod
    def of(cls, view: Slice, before: Array, after: Array) -> Cells:
        """Return the cells of a slice that have enough poses, with R draws of the errors of N poses ``(R, N)`` [m] before and after."""
        low, high = view.at.min(axis=0), view.at.max(axis=0)
        if view.from_axis:
            low[0] = 0.0
        width = max(float(np.max(high - low)), _LEAST_SPAN) / (_CELLS_ACROSS - (not view.from_axis))
        corner = (low + high - _CELLS_ACROSS * width) / 2
        if view.from_axis:
            corner[0] = 0.0
        cell = np.floor((view.at - corner) / width).astype(int)
        names, index, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
        drawn = np.flatnonzero(count >= _LEAST_POSES)
        means = [_means_of(draws, index.ravel(), len(count))[:, drawn] for draws in (before, after)]
        earlier, later = ([Banded.of(column) for column in mean.T] for mean in means)
        return cls(view, corner + (names[drawn] + 0.5) * width, width, count[drawn], (earlier, later))

    @property
    def shades(self) -> tuple[Array, Array]:
        """Return the values that the colours show [mm]: the error before, and the upper end of the band after."""
        before, after = self.found
        return np.array([b.value for b in before]) / MM, np.array([b.high for b in after]) / MM

    @property
    def spans(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the ranges of cells and measured poses along both axes [m]."""
        points = np.concatenate(
            [self.centres - self.width / 2, self.centres + self.width / 2, self.view.measured]
        )
        low, high = points.min(axis=0), points.max(axis=0)
        return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def _draw_cells(cells: Cells, edges: Array, file: str) -> Pair:
    """Return a slice before and after, in classes of colour with these upper edges [mm]."""
    view, centre = cells.view, cells.centres
    classes = [np.clip(np.searchsorted(edges, values), 0, _CLASSES - 1) for values in cells.shades]
    panels = []
    titles = (f"before, by the {NOMINAL}", f"after, by {file}: below this with 97.5 % certainty")
    for title, shade, banded in zip(titles, classes, cells.found, strict=True):
        panel = Panel(
            *cells.spans, title=title, x_label=view.labels[0], y_label=view.labels[1], to_scale=True
        )
        side = panel.points_across(cells.width) - _CELL_GAP
        for k in np.unique(shade):
            members = np.flatnonzero(shade == k)
            titles_of = [_cell_title(centre[i], banded[i], int(cells.count[i])) for i in members]
            panel.marks(centre[members, 0], centre[members, 1], titles_of, f"heat{k}", marker="s", size=side)
        some = np.unique(np.linspace(0, len(view.measured) - 1, _DOTS).astype(int))
        panel.marks(view.measured[some, 0], view.measured[some, 1], None, "ink", size=2.2, alpha=0.55)
        panels.append(panel)
    used = np.unique(np.concatenate(classes))
    what = f"mean error of the position over the workspace, seen {view.words}"
    return Pair(
        panels[0].markup(f"{what}, by the {NOMINAL}"),
        panels[1].markup(f"{what}, with {file}: the upper end of the 95 % band"),
        sentences(f"{what}, in millimetres.", "All maps have the same colours."),
        (
            *(("■", f"heat{k}", _shade_in_words(edges, int(k))) for k in range(used[0], used[-1] + 1)),
            (
                "•",
                "ink",
                "measured poses" if len(view.measured) <= _DOTS else f"{_DOTS} of the measured poses",
            ),
        ),
    )


def _cell_title(centre: Array, found: Banded, poses: int) -> str:
    """Return the text that a cell shows when it is pointed at."""
    return (
        f"about {number(centre[0], 2)} m, {number(centre[1], 2)} m: mean error {number(found.value / MM, 2)} mm, "
        f"95 % band {number(found.low / MM, 2)} to {number(found.high / MM, 2)} mm ({poses} poses)"
    )


def _means_of(draws: Array, index: Array, cells: int) -> Array:
    """Return the means ``(R, cells)`` over the poses in each cell, of draws ``(R, N)``; ``index`` ``(N,)`` is the cell of each pose."""
    order = np.argsort(index, kind="stable")
    starts = np.searchsorted(index[order], np.arange(cells))
    return np.add.reduceat(draws[:, order], starts, axis=1) / np.bincount(index, minlength=cells)


def _edges(smallest: float, largest: float) -> Array:
    """Return the upper edges ``(_CLASSES,)`` of the classes of colour [mm]: round numbers, of which the last is not below the largest value.

    The edges are the finest that still have one at or below the smallest value.
    """
    for in_decade in _STEPS:
        steps = np.array([step * 10.0**power for power in range(-12, 7) for step in in_decade])
        top = min(int(np.searchsorted(steps, largest)), len(steps) - 1)
        edges = steps[top - _CLASSES + 1 : top + 1]
        if edges[0] <= smallest:
            break
    return edges


def _shade_in_words(edges: Array, k: int) -> str:
    if k == 0:
        return f"below {edges[0]:g} mm"
    return f"{edges[k - 1]:g} to {edges[k]:g} mm"


def _draw_reach(view: Slice, before: Array, after: Array, file: str) -> Pair:
    """Return the mean error against the horizontal distance from the first joint's axis, with its band."""
    r = view.at[:, 0]
    edges = np.linspace(0.0, max(float(r.max()), _LEAST_SPAN), _SHELLS + 1)
    index = np.clip(np.digitize(r, edges) - 1, 0, _SHELLS - 1)
    kept = np.flatnonzero(np.bincount(index, minlength=_SHELLS) >= _LEAST_POSES)
    renumbered = np.searchsorted(kept, index)
    chosen = np.isin(index, kept)
    centre = (edges[:-1] + edges[1:])[kept] / 2
    curves = []
    for draws in (before, after):
        means = _means_of(draws[:, chosen], renumbered[chosen], len(kept))
        curves.append(np.array([[b.low, b.value, b.high] for b in map(Banded.of, means.T)]).T / MM)
    low, high = (float(f(curves)) for f in (np.min, np.max))
    panel = Panel(
        (0.0, float(edges[-1])),
        (max(low, 1e-4 * high) / 1.3, high * 1.3),
        title="",
        x_label=view.labels[0],
        y_label="mean error of the position [mm]",
        y_is_log=True,
    )
    for curve, colour in zip(curves, ("orange", "blue"), strict=True):
        panel.band(centre, curve[0], curve[2], colour)
        panel.line(centre, curve[1], colour)
    what = "mean error of the position against the distance from the first joint's axis"
    return Pair(
        panel.markup(f"{what}, before and after"),
        None,
        sentences(f"{what}, before and after, with the 95 % band; the scale is logarithmic."),
        (("━", "orange", f"before: {NOMINAL}"), ("━", "blue", f"after: {file}")),
    )
