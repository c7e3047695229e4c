"""Refuse data in which nothing moves, before a fit blames the robot for it."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.motion import faults_without_motion
from scalar.data.sensor_formats import sensor_formats
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

# Standard deviation of the places of the nominal flange across the plane that fits them best.
_LEAST_OUT_OF_PLANE = 10 * MM
_SEVERAL = 5  # points; fewer may have a coordinate in common
_RETURNS = 3  # poses at each place on average, from which on the places are stated, as those of sockets, and may have a coordinate in common
_STANDS = 2 * MM  # root mean square: a base that gives way moves a nest on it by less
# The same of the place on the flange that moves least: a tool that is taught to turn about a fixed point moves by less.
_MOVED = 20 * MM


def refuse_without_motion(dataset: Dataset) -> None:
    """Refuse a dataset whose poses, or whose points, are all the same, whose points lack a coordinate, or whose target is not on the flange.

    Raises:
        InvalidInput: All poses or all points are the same, a coordinate is the same at every point, or a target stays in its place.
    """
    table = sensor_formats()[dataset.sensor.kind].table
    items = dataset.point_columns.get("target")
    file = "points.csv" if table is None else table.files[0]
    faults = faults_without_motion(dataset.q, dataset.points, items, file)
    if faults := faults or _coordinates_filled_in(dataset, file) or _standing_targets(dataset, file):
        raise InvalidInput(faults)


def _coordinates_filled_in(dataset: Dataset, file: str) -> list[Fault]:
    """Return a fault for each coordinate that is the same number at every point, although the nominal arm moves in all three directions.

    A target that returns to a few places, whose coordinates are stated and not measured, may have one in common at all of them.
    """
    points = dataset.points[:, :3]
    if points.shape[1] != 3 or len(points) < _SEVERAL:
        return []
    same = np.flatnonzero(np.ptp(points, axis=0) == 0.0)
    if not len(same) or _RETURNS * len(np.unique(points, axis=0)) <= len(points):
        return []
    places = dataset.robot.flange(dataset.q)[:, :3, 3]
    smallest = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(places))
    if smallest < _LEAST_OUT_OF_PLANE:
        return []
    return [
        Fault(
            file,
            f"column {'xyz'[k]}: every value is {points[0, k] + 0.0:g} m, although the joints move the arm in all directions: it was probably "
            "filled in",
        )
        for k in same
    ]


def _standing_targets(dataset: Dataset, file: str) -> list[Fault]:
    """Return a fault for each target that stays in its place while the arm would move it, wherever on the flange it sat."""
    if not kind_of(dataset).measures_positions:
        return []
    pose = dataset.pose_of_point
    owner = dataset.point_columns.get("target", np.zeros(len(pose))).astype(int)
    session = np.zeros(dataset.n_poses) if dataset.session is None else np.asarray(dataset.session)
    T = dataset.robot.flange(dataset.q)[pose]
    faults = []
    for k in np.unique(owner):
        of_sessions = [
            rows
            for s in np.unique(session)
            if (rows := (owner == k) & (session[pose] == s)).sum() >= _SEVERAL
        ]
        measured = [_spread(dataset.points[rows]) for rows in of_sessions]
        if (
            not measured
            or max(measured) > _STANDS
            or min(_least_spread(T[rows]) for rows in of_sessions) < _MOVED
        ):
            continue
        which = f"target {dataset.targets[k]} stays" if len(dataset.targets) else "the measured points stay"
        faults.append(
            Fault(
                file,
                f"{which} in one place to {max(measured) / MM:.2g} mm, although the joints move the flange: what was measured is not on the flange. "
                "A nest on the base or the floor belongs into nests.csv, and anything else is to be left out",
            )
        )
    return faults


def _spread(points: Array) -> float:
    """Return the root mean square distance [m] of points ``(N, 3)`` from their mean."""
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))


def _least_spread(T: Array) -> float:
    """Return the smallest ``_spread`` [m] that any place on the flange has at frames ``(N, 4, 4)`` of it: 0 if the arm turns about a fixed point."""
    R, p = (part - part.mean(axis=0) for part in (T[:, :3, :3], T[:, :3, 3]))
    at = np.linalg.lstsq(R.reshape(-1, 3), -p.ravel(), rcond=None)[0]
    return _spread(p + R @ at)
