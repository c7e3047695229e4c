"""Sort random poses of an arm into square cells of two views of its workspace, and compute the error in each cell.

One view is from the side (horizontal distance from the first joint's axis, height), the other from above. A cell has the mean error over its poses,
which have all orientations of the wrist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.evaluate.workspace_errors import Banded, Sizes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.units import MM

LEAST_POSES = 3  # a cell with fewer poses is not drawn
LEAST_SPAN = 1e-3  # m: least width of a view, since the poses of an arm of one joint may not have any
_CELLS_ACROSS = 18
_LEVEL = 0.99  # cosine of the angle between two directions, above which they count as the same


@dataclass(frozen=True, eq=False)
class Slice:
    """The positions of poses in one view of the workspace.

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


def slices(robot: Robot, position: Array, measured: Array) -> tuple[Slice, Slice]:
    """Return the view from the side and the view from above.

    Args:
        robot: The nominal arm, whose first joint's axis and whose direction of gravity decide the views.
        position: ``(N, 3)`` [m], positions of the random poses in the base frame.
        measured: ``(M, 3)`` [m], positions of the measured poses in the base frame.
    """
    up = -robot.down if robot.down.any() else np.array([0.0, 0.0, 1.0])
    level = abs(up[2]) > _LEVEL
    first = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < _LEVEL else np.array([0.0, 1.0, 0.0])
    first = first - up * (first @ up)
    first /= np.linalg.norm(first)
    second = np.cross(up, first) if up[2] >= 0 else np.cross(first, up)
    axis = robot.T_base_0[:3, 3]

    def seen(points: Array) -> tuple[Array, Array]:
        """Return points ``(N, 3)`` as ``(N, 2)`` in the view from the side and in that from above."""
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
    """One view in square cells, with the errors in each.

    Attributes:
        view: The view.
        centres: ``(C, 2)`` [m], centres of the cells that are drawn.
        width: Width of a cell [m].
        count: ``(C,)``, number of poses in each cell.
        found: Mean error [m] of each cell with its band, before and after.
    """

    view: Slice
    centres: Array
    width: float
    count: Array
    found: tuple[list[Banded], list[Banded]]

    @classmethod
    def of(cls, view: Slice, before: Sizes, after: Sizes) -> Cells:
        """Return the cells of a view that have enough poses.

        Args:
            view: The view, with N random poses.
            before: The errors of these poses before.
            after: The same after.
        """
        low, high = view.at.min(axis=0), view.at.max(axis=0)
        if view.from_axis:
            low[0] = 0.0
        width = max(float(np.max(high - low)), LEAST_SPAN) / (_CELLS_ACROSS - (not view.from_axis))
        corner = (low + high - _CELLS_ACROSS * width) / 2
        if view.from_axis:
            corner[0] = 0.0
        cell = np.floor((view.at - corner) / width).astype(int)
        names, index, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
        drawn = np.flatnonzero(count >= LEAST_POSES)
        earlier, later = (
            errors.each_banded(lambda draws: means_of(draws, index.ravel(), len(count))[:, drawn])
            for errors in (before, after)
        )
        return cls(view, corner + (names[drawn] + 0.5) * width, width, count[drawn], (earlier, later))

    @property
    def shades(self) -> tuple[Array, Array, Array, Array]:
        """Return the values that the colours show [mm], each ``(C,)``: the errors before and after, then the upper ends of their bands."""
        before, after = self.found
        values = (
            [b.value for b in before],
            [b.value for b in after],
            [b.high for b in before],
            [b.high for b in after],
        )
        return tuple(np.array(of_cells) / MM for of_cells in values)  # type: ignore[return-value]

    @property
    def spans(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the ranges of cells and measured poses along both axes [m]."""
        points = np.concatenate(
            [self.centres - self.width / 2, self.centres + self.width / 2, self.view.measured]
        )
        low, high = points.min(axis=0), points.max(axis=0)
        return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def means_of(draws: Array, index: Array, cells: int) -> Array:
    """Return the means ``(R, cells)`` over the poses in each cell, of draws ``(R, N)``; ``index`` ``(N,)`` is the cell of each pose."""
    order = np.argsort(index, kind="stable")
    starts = np.searchsorted(index[order], np.arange(cells))
    return np.add.reduceat(draws[:, order], starts, axis=1) / np.bincount(index, minlength=cells)
