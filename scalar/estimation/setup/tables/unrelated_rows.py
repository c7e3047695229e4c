"""Measurements that belong to other rows of poses.csv (some rows before or after their own), or to no row, as those of another campaign.

Whatever is wrong in the description of an arm, the place of its wrist is a sum of products of the cosines and sines of its first joint angles (of
travels themselves), in any frame, for any zeros and signs. A regression of the measured places on these products needs neither the table of joints
nor the tracker's frame. If it explains no more of their variance than it does for measurements in random order, the measurements have nothing to do
with these joint angles, and no sign or zero needs to be searched for.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative, readings_of_labels
from scalar.estimation.setup.other_angles import shifted
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

FARTHEST_ROW = 10  # rows
# Fewer poses may show no relation by chance: some sets of 45 poses of arms with seven joints show none.
LEAST_POSES = 60
FIRST_JOINTS = 3  # that move the wrist of most arms
POSES_PER_COLUMN = 2  # fewest poses for each column of the regression
_RECURRING = 0.8  # share of equal labels; with planes in turn all are equal but a few mistakes, with three planes at random a third is
_FARTHEST = 4.0  # times the median distance from the median place, chosen: an arm reaches hardly so far
_ORDERS = 200  # random orders with which the order of the table is compared


def rows_apart(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which each measurement belongs to a pose some rows before or after its own; one row is tried elsewhere."""
    for labels_go_along in readings_of_labels(dataset):
        for rows in range(2, min(FARTHEST_ROW, dataset.n_poses // 3) + 1):
            for shift in (rows, -rows) if not _labels_recur(dataset, rows) else ():
                yield Alternative(
                    "shifted_poses",
                    "poses.csv",
                    f"each measurement belongs to the pose {rows} rows {'before' if shift > 0 else 'after'} the one that it is listed with",
                    f"with the joint angles moved by {rows} rows",
                    "look where the rows of angles and of measurements were joined",
                    shifted(dataset, np.full(dataset.n_poses, shift), labels_go_along),
                )


def _labels_recur(dataset: Dataset, rows: int) -> bool:
    """Return whether the labels of a touch probe, which measures nothing else, are the same some rows on: moved rows are then only rows left out."""
    if len(dataset.points) or not dataset.planes:
        return False
    plane = dataset.plane_index
    return float(np.mean(plane[rows:] == plane[:-rows])) > _RECURRING


def unrelated(dataset: Dataset) -> bool:
    """Return whether the measured places have nothing to do with the joint angles of their row, of a row near it, or of the reverse order.

    False where no places in space were measured, or too few. Only the session with the most places counts, because a tracker that was moved measures
    in another frame.
    """
    places = _places(dataset)
    seen = np.flatnonzero(np.isfinite(places[:, 0]))
    if dataset.session is not None:
        session = dataset.session[seen]
        seen = seen[session == np.argmax(np.bincount(session, minlength=1))]
    if len(seen) < LEAST_POSES:
        return False
    # A few readings that are metres off would have most of the variance.
    away = np.linalg.norm(places[seen] - np.median(places[seen], axis=0), axis=1)
    seen = seen[away <= _FARTHEST * np.median(away)]
    if len(seen) < LEAST_POSES:
        return False
    centred = places[seen] - places[seen].mean(axis=0)
    columns = _products(dataset.q[seen], dataset.robot.slides)
    basis = np.linalg.qr(columns - columns.mean(axis=0))[0]
    rng, n = np.random.default_rng(0), len(seen)

    def share(order: Array) -> float:
        """Return the share of the variance of the places that is explained where they belong to the poses in another order."""
        return float(np.sum((basis.T @ centred[order]) ** 2) / max(np.sum(centred**2), 1e-300))

    rows = np.arange(n)
    near = [share(np.roll(rows, shift)) for shift in range(-FARTHEST_ROW, FARTHEST_ROW + 1)]
    by_chance = max(share(rng.permutation(n)) for _ in range(_ORDERS))
    return max(*near, share(rows[::-1])) < by_chance


def _products(q: Array, slides: Array) -> Array:
    """Return the products ``(N, k)`` of 1, cosine and sine (or the travel) of the first joints that move, as many joints as the poses allow."""
    columns = np.ones((len(q), 1))
    moving = [j for j in range(q.shape[1]) if np.ptp(q[:, j]) > 0]
    for j in moving[:FIRST_JOINTS]:
        own = [np.ones(len(q)), *([q[:, j]] if slides[j] else [np.cos(q[:, j]), np.sin(q[:, j])])]
        wider = (columns[:, :, None] * np.stack(own, axis=1)[:, None, :]).reshape(len(q), -1)
        if POSES_PER_COLUMN * wider.shape[1] > len(q):
            break
        columns = wider
    return columns[:, 1:]


def _places(dataset: Dataset) -> Array:
    """Return the measured place of the target that most poses show ``(N, 3)`` [m]; NaN where it was not measured."""
    places = np.full((dataset.n_poses, 3), np.nan)
    if dataset.planes or dataset.points.ndim != 2 or dataset.points.shape[1] != 3:
        return places
    pose = dataset.pose_of_point
    target = dataset.point_columns.get("target", np.zeros(len(dataset.points))).astype(int)
    mine = target == np.argmax(np.bincount(target, minlength=1)) if len(target) else target == 0
    places[pose[mine]] = dataset.points[mine]
    return places


def unrelated_in_words(dataset: Dataset) -> str:
    """Return what is wrong with measurements that are ``unrelated`` to the joint angles, and what to do."""
    file = kind_of(dataset).format.measured_in
    return (
        f"the measurements in {file} do not belong to the joint angles in poses.csv: the angles explain no more of the measured places than in "
        f"random order, and the same holds if the rows are moved by up to {FARTHEST_ROW} rows, or reversed; check whether both files are of one "
        "campaign, and whether the numbers in their column pose mean the same poses"
    )
