"""Poses that are set aside as gross errors, follow each other, and fit as well as the others with a session of their own.

``moved_targets`` finds a tracker that was set up anew if the whole dataset does not fit. Single gross errors beside it hide the move from
that search, and one of the two parts would be set aside pose by pose.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.gross_errors import clean
from scalar.estimation.setup.moved_target import LEAST_POSES, LEAST_SCANS
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.estimation.setup.trial import full_fit
from scalar.geometry.se3 import Array

MOST_WITHIN = 0.1  # chosen, of the poses of the run: as many may fit the others by chance
MOST_BESIDE = 0.2  # chosen, of the other poses: as many may be gross errors


def unstated_session(dataset: Dataset, set_aside: Collection[int]) -> tuple[Suspicion, Array] | None:
    """Return a suspicion that a session of its own is missing in poses.csv, and which poses it concerns ``(N,)`` bool; None if there is none.

    Args:
        dataset: As it was given, before cleaning, in the order of acquisition.
        set_aside: Ids of the poses that were set aside.
    """
    aside = np.isin(dataset.pose_ids, list(set_aside))
    least = LEAST_SCANS if dataset.planes else LEAST_POSES
    if aside.sum() < least:
        return None
    session = np.zeros(dataset.n_poses, dtype=int) if dataset.session is None else dataset.session
    for own in np.unique(session[aside]):
        rows = np.flatnonzero(session == own)
        run = _run(aside[rows], least)
        if run is None:
            continue
        moved = np.zeros(dataset.n_poses, dtype=bool)
        moved[rows[run]] = True
        if (found := _suspicion(dataset, aside, moved, session)) is not None:
            return found, moved
    return None


def _run(aside: Array, least: int) -> slice | None:
    """Return the rows at the end or at the beginning of a session that were set aside, nearly all of them, where nearly no other was; else None."""
    n = len(aside)
    if n < 2 * least:
        return None
    before = np.concatenate([[0], np.cumsum(aside)])
    breaks = np.arange(least, n - least + 1)
    late = (
        before[breaks] + (n - breaks) - (before[n] - before[breaks])
    )  # poses at odds with a run from there on
    early = n - late
    k = int(breaks[np.argmin(late)] if late.min() <= early.min() else breaks[np.argmin(early)])
    run, rest = (slice(k, n), slice(0, k)) if late.min() <= early.min() else (slice(0, k), slice(k, n))
    if np.mean(~aside[run]) > MOST_WITHIN or np.mean(aside[rest]) > MOST_BESIDE:
        return None
    return run


def _suspicion(dataset: Dataset, aside: Array, moved: Array, session: Array) -> Suspicion | None:
    """Return the suspicion if nearly all of the poses ``moved`` ``(N,)`` agree with the others given a session of their own; else None."""
    with_own = replace(dataset, poses=dataset.poses.assign(session=2 * session + moved))
    try:
        wrong = np.isin(dataset.pose_ids, clean(with_own).outlier_poses)
    except ScalarError:
        return None
    if wrong[moved].mean() > MOST_BESIDE or wrong.sum() > aside.sum() - (1 - MOST_BESIDE) * moved.sum():
        return None
    with_it = full_fit(with_own.subset(~wrong))
    if with_it is None:
        return None
    ids, rows = dataset.pose_ids, np.flatnonzero(moved)
    at = rows[0] if rows[0] else rows[-1] + 1
    what = "the planes or the arm's base were" if dataset.planes else "the tracker or the arm's base was"
    return Suspicion(
        "session",
        f"pose {ids[at]}",
        f"poses {ids[rows[0]]} to {ids[rows[-1]]} contradict the others, and {np.sum(moved & ~wrong)} of these {len(rows)} fit with a session "
        f"of their own (to {in_mm(with_it.rms)} mm in the median): {what} probably set up anew before pose {ids[at]}; write a column session "
        f"into poses.csv whose value changes at pose {ids[at]}",
        None,
        with_it.rms,
    )
