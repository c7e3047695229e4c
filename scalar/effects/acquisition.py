"""Properties of a dataset that effects need: which joints move, when poses were measured, where planes were measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.moves import moves, side_column, still
from scalar.data.path import follow_one_path
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


ENOUGH_MOVES = 0.8  # least share of poses whose last move is known: with fewer, effects of moves are not looked for (chosen)

LEVEL = 0.01  # rad or m: positions of a joint that differ by less count as one (chosen)
LEAST_LEVELS = 10  # positions of a joint from which curves over them are looked for (chosen: one more than the coefficients of a smooth curve)

ALWAYS = -np.inf  # order of acquisition at which an effect begins that acts all the time


def knock_std(units: Sequence[str]) -> Array:
    """Return the prior standard deviations of a sudden shift and turn: two centimetres and three degrees, since a knock may move a thing far.

    Args:
        units: Of the coefficients, metres (``m``) or radians.
    """
    return np.array([0.02 if unit == "m" else 0.05 for unit in units])


def moving_joints(dataset: Dataset) -> list[int]:
    """Return the joints, from 1, that move in the dataset."""
    moved = np.ptp(dataset.q, axis=0) > still(dataset.robot.slides)
    return [int(j) + 1 for j in np.flatnonzero(moved)]


def turning_joints(dataset: Dataset) -> list[int]:
    """Return the revolute joints, from 1, that move in the dataset."""
    return [j for j in moving_joints(dataset) if not dataset.robot.slides[j - 1]]


def swept_joints(dataset: Dataset) -> list[int]:
    """Return the joints, from 1, that take so many positions that a curve over them is determined between them.

    On a grid a joint takes a few positions. An error at each of them is a fact, but waves of many orders run through them, and differ in between.
    """
    levels = {j: len(np.unique(np.round(dataset.q[:, j - 1] / LEVEL))) for j in moving_joints(dataset)}
    return [j for j, count in levels.items() if count >= LEAST_LEVELS]


def steps_are_known(dataset: Dataset) -> bool:
    """Return whether the order of the poses shows the last move of the arm for at least the share ``ENOUGH_MOVES`` of them."""
    known = moves(dataset.poses, dataset.robot.slides)
    moved = np.any([known[side_column(j)] != 0 for j in moving_joints(dataset)] or [[False]], axis=0)
    return bool(np.mean(moved) >= ENOUGH_MOVES)


def order_and_time(dataset: Dataset) -> tuple[Array, Array | None]:
    """Return the order of acquisition ``(N,)``, that of the rows if none is recorded, and the time ``(N,)`` [s], or None if it is not recorded."""
    poses = dataset.poses
    order = (
        poses["order"].to_numpy(dtype=float) if "order" in poses else np.arange(dataset.n_poses, dtype=float)
    )
    return order, poses["time"].to_numpy(dtype=float) if "time" in poses else None


def on_one_path(dataset: Dataset) -> bool:
    """Return whether the poses, in the order in which they were measured, follow one path (``follow_one_path``)."""
    return follow_one_path(
        dataset.q[np.argsort(order_and_time(dataset)[0], kind="stable")], still(dataset.robot.slides)
    )


def used_planes(dataset: Dataset) -> list[str]:
    """Return the names of the planes that poses measure, in the order of the dataset."""
    return [dataset.planes[k].name for k in np.unique(dataset.plane_index) if k >= 0]


def on_plane(dataset: Dataset, plane: str) -> Array:
    """Return which poses measure a plane, ``(N,)`` bool."""
    return dataset.plane_index == [guess.name for guess in dataset.planes].index(plane)


def plane_centre(dataset: Dataset, plane: str) -> tuple[float, float, float]:
    """Return the mean position of the nominal sensor over a plane, projected onto the initial guess of that plane; base frame [m]."""
    k = next(i for i, guess in enumerate(dataset.planes) if guess.name == plane)
    T_sensor = np.eye(4) if dataset.sensor.T_flange_sensor is None else dataset.sensor.T_flange_sensor
    origins = (dataset.robot.flange(dataset.q[dataset.plane_index == k]) @ T_sensor)[:, :3, 3]
    middle = origins.mean(axis=0)
    guess = dataset.planes[k]
    x, y, z = middle - guess.normal * (guess.normal @ middle - guess.distance)
    return float(x), float(y), float(z)


def range_middle(dataset: Dataset) -> float:
    """Return the middle [m] between the shortest and the longest measured range, along the axis in which the scanner errs.

    Makers state the linearity of a scanner as its deviation from the best straight line over the whole measuring range. For a curved error, this
    line is parallel to the curve in the middle of that range. A scanner that scans planes from many distances measures out to both ends of its
    range, so the extent of the measured ranges shows where the middle is; their mean does not, since it depends on where the poses are.
    """
    points = dataset.points
    ranges = points[:, 1] if dataset.sensor.error_axis == "z" else np.linalg.norm(points, axis=1)
    return float((ranges.min() + ranges.max()) / 2)


def missing_column(dataset: Dataset, name: str) -> str | None:
    """Return a clause that poses.csv lacks a column, or None if the dataset has it."""
    return None if name in dataset.poses else f"poses.csv has no column '{name}'"


def numbered(dataset: Dataset) -> Dataset:
    """Return a dataset with its rows counted from 0 in a column ``order``, or itself if it has that column.

    A pose then keeps its number where others are set aside.
    """
    if "order" in dataset.poses:
        return dataset
    return replace(dataset, poses=dataset.poses.assign(order=np.arange(dataset.n_poses)))
