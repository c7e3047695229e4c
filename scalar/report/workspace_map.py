"""Show the error of the arm over its workspace, by its data sheet and as calibrated.

There is a table, a map of square cells (``workspace_cells``) in a view from the side and one from above, the same maps of the upper ends of the
bands, and a curve of the error against the distance from the first joint's axis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.evaluate.model_discrepancy import NOTHING_LACKS, ModelDiscrepancy
from scalar.evaluate.workspace_errors import (
    MEAN_OVER_RMS,
    NOMINAL,
    Banded,
    Sizes,
    WorkspaceErrors,
    errors_within_limits,
    mean_over_poses,
)
from scalar.geometry.se3 import Array
from scalar.report.panel import Panel
from scalar.report.pictures import Pair, sentences
from scalar.report.scale_words import if_scale_is_right, scale_in_words
from scalar.report.words import number
from scalar.report.workspace_cells import LEAST_POSES, LEAST_SPAN, Cells, Slice, means_of, slices
from scalar.units import MM

WITHOUT_EFFECTS, SHIPPED = "before.json", "after.json"
_SHELLS = 12  # number of points of the curve over the distance from the first joint's axis
_DOTS = 150  # largest number of measured poses that are drawn
_STEPS = ((1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))  # edges of the colour classes in a decade, the finest first
_CLASSES = 9  # number of colour classes
_MOST = 0.95  # the table's upper bound holds for this share of the poses
_CELL_GAP = 0.6  # gap between two cells [pt]
_NUMBERS, _UPPER_ENDS = (0, 1), (2, 3)  # their places among the values of ``Cells.shades``, before and after
_WHAT = "mean error of the position over the workspace"
_LEAST_ERROR = 1e-9  # m: smaller errors are rounding, and no picture is drawn


def workspace_section(
    judged: Calibration,
    without_effects: Model | None,
    measured_poses: Poses,
    file: str,
    discrepancy: ModelDiscrepancy = NOTHING_LACKS,
) -> dict[str, Any] | None:
    """Return the table and the pictures of the errors over the workspace, or None if there is no covariance, or no error.

    Args:
        judged: The calibration, with its covariance.
        without_effects: The model without effects, if it is another one; or None.
        measured_poses: The poses with what was recorded of them.
        file: File name of the calibration, for the texts.
        discrepancy: What the model of the calibration may lack. Every figure counts its possible effects by their probability; the upper ends of the
            bands allow for its excess and its hidden effects besides.
    """
    models = {**({} if without_effects is None else {WITHOUT_EFFECTS: without_effects}), file: judged.model}
    errors = errors_within_limits(judged, models, measured_poses, discrepancy)
    return None if errors is None else section_of_errors(judged, errors, measured_poses, file, discrepancy)


def section_of_errors(
    judged: Calibration,
    errors: WorkspaceErrors,
    measured_poses: Poses,
    file: str,
    discrepancy: ModelDiscrepancy,
) -> dict[str, Any] | None:
    """Return the section as ``workspace_section`` does, of errors that are known: of the data sheet, of the model of ``file``, and of others."""
    robot, sizes = judged.model.nominal, errors.all_sizes
    if max(float(draws.found.max()) for draws in sizes.values()) < _LEAST_ERROR:
        return None
    bases = EffectBases.of(robot, measured_poses, judged.model.effects)
    measured = Kinematics.of(judged.model, measured_poses, bases).T_base_sensor[:, :3, 3]
    side, top = slices(robot, errors.position, measured)
    before, after = sizes[NOMINAL], sizes[file]
    cells = [Cells.of(view, before, after) for view in (side, top)]
    shades = np.concatenate([shade for one in cells for shade in one.shades])
    edges = _edges(float(shades.min()), float(shades.max()))
    pictures = [draw(one, edges, file) for draw in (_draw_cells, _draw_upper_ends) for one in cells]
    return {
        "rows": [
            {
                "state": model,
                "mean": banded_in_words(draws, mean_over_poses),
                "most": banded_in_words(draws, most_errors),
            }
            for model, draws in sizes.items()
        ],
        "poses": len(errors.position),
        "excess": f"{number(MEAN_OVER_RMS * discrepancy.excess / MM)} mm" if discrepancy.excess else "",
        "left_open": "",
        "within_ranges": "",
        "repeated": "",
        "hidden": ", ".join(discrepancy.hidden_kinds),
        "scale": scale_in_words(judged),
        "if_scale_is_right": if_scale_is_right(judged),
        "pictures": [*pictures, _draw_reach(side, before, after, file)],
    }


def most_errors(draws: Array) -> Array:
    """Return the error ``(R,)`` [m] that most poses of each draw ``(R, N)`` do not exceed."""
    return np.quantile(draws, _MOST, axis=1)


def banded_in_words(draws: Sizes, of_poses: Callable[[Array], Array]) -> dict[str, str]:
    """Return a number of the sizes of errors and its band in millimetres, all with as many decimals as the number has.

    Args:
        draws: The sizes.
        of_poses: Takes draws ``(R, N)`` [m] and returns the number of each ``(R,)``: ``mean_over_poses`` or ``most_errors``.
    """
    found = draws.banded(of_poses)
    value = number(found.value / MM)
    decimals = len(value.partition(".")[2])
    return {
        "value": f"{value} mm",
        "band": f"{found.low / MM:.{decimals}f} to {found.high / MM:.{decimals}f} mm",
    }


def _draw_cells(cells: Cells, edges: Array, file: str) -> Pair:
    """Return the maps of a view before and after, both of the number, in classes of colour with the upper edges ``(_CLASSES,)`` [mm]."""
    what = f"{_WHAT}, seen {cells.view.words}"
    captions = (f"{what}, in millimetres.", "All maps have the same colours.")
    return _before_and_after(cells, edges, file, _NUMBERS, what, ("before", "after"), captions)


def _draw_upper_ends(cells: Cells, edges: Array, file: str) -> Pair:
    """Return the maps of a view before and after of the upper ends of the bands, in the same classes of colour."""
    what = f"the upper end of the 95 % band of that error, seen {cells.view.words}"
    captions = (
        f"{what}, in millimetres: with 97.5 % certainty the error is below it.",
        "The colours are those of the maps above.",
    )
    return _before_and_after(
        cells, edges, file, _UPPER_ENDS, what, ("before, at most", "after, at most"), captions
    )


def _before_and_after(
    cells: Cells,
    edges: Array,
    file: str,
    which: tuple[int, int],
    what: str,
    titles: tuple[str, str],
    captions: Sequence[str],
) -> Pair:
    """Return the two maps of a view, of two of the values of ``Cells.shades``."""
    states = (f"by the {NOMINAL}", f"by {file}")
    panels = [
        _panel(cells, edges, k, f"{title}, {state}")
        for k, title, state in zip(which, titles, states, strict=True)
    ]
    return Pair(
        panels[0].markup(f"{what}, by the {NOMINAL}"),
        panels[1].markup(f"{what}, with {file}"),
        sentences(*captions),
        _key(cells, edges, which),
    )


def _panel(cells: Cells, edges: Array, which: int, title: str) -> Panel:
    """Return the map of one of the values of ``Cells.shades``; a cell shows the error and its band when it is pointed at."""
    view, centre = cells.view, cells.centres
    banded = cells.found[which % 2]
    shade = _classes(cells, edges, which)
    panel = Panel(*cells.spans, title=title, x_label=view.labels[0], y_label=view.labels[1], to_scale=True)
    side = panel.points_across(cells.width) - _CELL_GAP
    for k in np.unique(shade):
        members = np.flatnonzero(shade == k)
        titles_of = [_cell_title(centre[i], banded[i], int(cells.count[i])) for i in members]
        panel.marks(centre[members, 0], centre[members, 1], titles_of, f"heat{k}", marker="s", size=side)
    some = np.unique(np.linspace(0, len(view.measured) - 1, _DOTS).astype(int))
    panel.marks(view.measured[some, 0], view.measured[some, 1], None, "ink", size=2.2, alpha=0.55)
    return panel


def _classes(cells: Cells, edges: Array, which: int) -> Array:
    """Return the class of colour of every cell ``(C,)`` by one of the values of ``Cells.shades``."""
    return np.clip(np.searchsorted(edges, cells.shades[which]), 0, _CLASSES - 1)


def _key(cells: Cells, edges: Array, which: Sequence[int]) -> tuple[tuple[str, str, str], ...]:
    """Return the legend of maps of some of the values of ``Cells.shades``: the classes of colour that they use, and the measured poses."""
    used = np.concatenate([_classes(cells, edges, k) for k in which])
    measured = len(cells.view.measured)
    return (
        *(("■", f"heat{k}", _shade_in_words(edges, int(k))) for k in range(used.min(), used.max() + 1)),
        ("•", "ink", "measured poses" if measured <= _DOTS else f"{_DOTS} of the measured poses"),
    )


def _cell_title(centre: Array, found: Banded, poses: int) -> str:
    """Return the text that a cell shows when it is pointed at."""
    return (
        f"about {number(centre[0], 2)} m, {number(centre[1], 2)} m: mean error {number(found.value / MM, 2)} mm, "
        f"95 % band {number(found.low / MM, 2)} to {number(found.high / MM, 2)} mm ({poses} poses)"
    )


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
    """Return the range of errors that a class of colour stands for, for the legend."""
    if k == 0:
        return f"below {edges[0]:g} mm"
    return f"{edges[k - 1]:g} to {edges[k]:g} mm"


def _draw_reach(view: Slice, before: Sizes, after: Sizes, file: str) -> Pair:
    """Return the mean error against the horizontal distance from the first joint's axis, with its band."""
    r = view.at[:, 0]
    edges = np.linspace(0.0, max(float(r.max()), LEAST_SPAN), _SHELLS + 1)
    index = np.clip(np.digitize(r, edges) - 1, 0, _SHELLS - 1)
    kept = np.flatnonzero(np.bincount(index, minlength=_SHELLS) >= LEAST_POSES)
    renumbered = np.searchsorted(kept, index)
    chosen = np.isin(index, kept)
    centre = (edges[:-1] + edges[1:])[kept] / 2
    curves = []
    for errors in (before, after):
        banded = errors.each_banded(lambda draws: means_of(draws[:, chosen], renumbered[chosen], len(kept)))
        curves.append(np.array([[b.low, b.value, b.high] for b in banded]).T / MM)
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
