"""How far tracked points of one pose scatter when the arm comes back to it: no model of the joint angles can predict them better.

A return is a further standstill at the same joint angles, in the same session and with the same load; readings of one standstill are averaged. The
scatter holds the arm's repeatability, the noise of the tracker, and what changed in between and depends on no joint angle (temperature, a drift of
the tracker, the direction of approach).

Logged angles of one commanded pose differ a little from return to return. With a calibrated model, what these differences move by the arm's geometry
is subtracted from the points before they are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.formats import PAYLOAD
from scalar.diagnosis.held_out.repetitions import first_of_repetitions
from scalar.estimation.design_effect import standstills
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

# rad, or m of a joint that slides (chosen): logged angles of one commanded pose differ by some hundredths of a milliradian, and the wave of a gear
# error of order 512 is a hundred times as long.
SAME_ANGLES = 1e-4
LEAST_RETURNS = 5  # chosen: fewer give a scatter that is wrong by a third or more
_COORDINATES = 3  # of a tracked point


@dataclass(frozen=True)
class RepeatedPoses:
    """The scatter of poses to which the arm came back.

    Attributes:
        scatter: Root mean square distance [m] of a point from its mean over the standstills at the same joint angles, by their degrees of freedom.
        returns: Number of standstills beyond the first at each pose.
        poses: Number of poses to which the arm came back.
        freedom: Degrees of freedom of the scatter, each of a point in space: three of a coordinate.
        by_stated_noise: What ``scatter`` would be expected to be if the stated noise were its only cause [m]; None if no noise is stated.
    """

    scatter: float
    returns: int
    poses: int
    freedom: int
    by_stated_noise: float | None


def repeated_poses(dataset: Dataset, model: Model | None = None) -> RepeatedPoses | None:
    """Return the scatter of poses to which the arm came back; None without tracked points, or with too few returns.

    Args:
        dataset: What was measured.
        model: Calibrated with the same data; only its rigid part is used. It predicts how far the points move by the small differences of the angles
            at returns (less than ``SAME_ANGLES`` in each joint), which is then no part of the scatter. None leaves it in, and so does a sensor that
            measures in its own frame.
    """
    if dataset.planes or dataset.points.shape[1:] != (_COORDINATES,) or not len(dataset.points):
        return None
    points = dataset.points
    if model is not None and kind_of(dataset).measures_positions:
        points = points - _expected(dataset, model)
    # One mean for each target at each standstill, and the place of each of these means.
    read, of_mean = np.unique(_read_at(dataset), axis=0, return_inverse=True)
    of_mean, readings = of_mean.ravel(), len(read)
    means = _means(points, of_mean, readings)
    places, of_place = np.unique(read[:, :2], axis=0, return_inverse=True)
    of_place = of_place.ravel()
    off = means - _means(means, of_place, len(places))[of_place]
    count = np.bincount(of_place)
    freedom = int(np.sum(count - 1))
    standing = np.unique(read[:, [0, 2]], axis=0)[:, 0]
    at_place = np.unique(standing, return_counts=True)[1]
    returns = int(np.sum(at_place - 1))
    if returns < LEAST_RETURNS or freedom < LEAST_RETURNS:
        return None
    scatter = float(np.sqrt(np.sum(off**2) / freedom))
    by_noise = None
    if (noise := _stated_noise(dataset)) is not None:
        variances = _means(noise[:, None] ** 2, of_mean, readings)[:, 0] / np.bincount(of_mean)
        left = 1.0 - 1.0 / count[of_place]  # of a mean's variance, after the mean of its place is subtracted
        by_noise = float(np.sqrt(_COORDINATES * np.sum(variances * left) / freedom))
    return RepeatedPoses(scatter, returns, int(np.sum(at_place > 1)), freedom, by_noise)


def _read_at(dataset: Dataset) -> Array:
    """Return for each of P points ``(P, 3)`` the place of its pose, its target, and the standstill at which it was read.

    Poses have the same place if they have the same joint angles, session (the tracker may stand elsewhere in another) and load.
    """
    known = dataset.known_poses
    standstill = standstills(dataset.q, known.order)
    session = np.zeros(dataset.n_poses) if dataset.session is None else dataset.session
    load = known.columns.get(PAYLOAD[0], np.zeros(dataset.n_poses))
    others = np.column_stack([session, np.nan_to_num(np.asarray(load, dtype=float), nan=-1.0)])
    place = first_of_repetitions(np.column_stack([dataset.q, others]), SAME_ANGLES)
    target = dataset.point_columns.get("target", np.zeros(len(dataset.points)))
    return np.column_stack([place[dataset.pose_of_point], target, standstill[dataset.pose_of_point]])


def _expected(dataset: Dataset, model: Model) -> Array:
    """Return where the geometry of a model has each point ``(P, 3)`` [m], in the tracker's frame."""
    rigid = replace(model, effects=())
    residuals = Residuals.of(dataset, rigid)
    frames: Any = rigid.target
    T = frames.transforms[residuals.measurement.target_index] @ residuals.kinematics(rigid).T_base_sensor
    numbers = dataset.point_columns.get("target", np.zeros(len(dataset.points)))
    # The model has the targets that were seen, in this order.
    _, among_seen = np.unique(numbers, return_inverse=True)
    on_flange = frames.targets.transforms[among_seen]
    return (T[dataset.pose_of_point] @ on_flange)[:, :3, 3]


def _stated_noise(dataset: Dataset) -> Array | None:
    """Return the stated standard deviation ``(P,)`` [m] of a coordinate of every point; None if it is not stated for all of them."""
    own, common = dataset.point_columns.get("noise"), dataset.sensor.noise
    everywhere = np.full(len(dataset.points), np.nan if common is None else float(common))
    stated = everywhere if own is None else np.where(np.isfinite(own), own, everywhere)
    return stated if np.isfinite(stated).all() else None


def _means(points: Array, index: Array, groups: int) -> Array:
    """Return the mean ``(groups, c)`` of the rows ``(P, c)`` of each group; ``index`` ``(P,)`` is the group of each point."""
    sums = np.zeros((groups, points.shape[1]))
    np.add.at(sums, index, points)
    return sums / np.bincount(index, minlength=groups)[:, None]
