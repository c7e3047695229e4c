"""Poses that are set aside as gross errors, follow each other, and fit as well as the others with a session of their own.

A tracker that was set up anew is found (``moved_target``) where the whole dataset does not fit in one part. With single gross errors besides, it is
not: the poses before the move, or those after it, would then be set aside one by one.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.gross_errors import clean
from scalar.estimation.setup.sessions.moved_target import LEAST_POSES, LEAST_SCANS
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.estimation.setup.trial import full_fit
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

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


def run_set_aside(dataset: Dataset, set_aside: Collection[int]) -> Suspicion | None:
    """Return a suspicion that something changed on the flange if poses that follow each other were set aside; None if there are no such poses.

    It is for a run of poses that no session of their own explains (``unstated_session``): a session frees the place of base and target, and not that
    of the sensor.

    Args:
        dataset: As it was given, before cleaning, in the order of acquisition.
        set_aside: Ids of the poses that were set aside.
    """
    aside = np.isin(dataset.pose_ids, list(set_aside))
    run = _run(aside, LEAST_SCANS if dataset.planes else LEAST_POSES)
    if run is None:
        return None
    ids = dataset.pose_ids[run]
    at = ids[0] if run.start else dataset.pose_ids[run.stop]
    return Suspicion(
        "run",
        f"pose {at}",
        f"nearly all poses from {ids[0]} to {ids[-1]}, which follow each other, contradict the others and were set aside: something changed at pose "
        f"{at}. Was the {kind_of(dataset).on_flange[0]} moved or exchanged on the flange, or another arm measured? The answer is of the other poses "
        "alone; diagnose these as a campaign of their own",
    )


def _run(aside: Array, least: int) -> slice | None:
    """Return the rows at the end or at the beginning of a session that were set aside, nearly all of them, where nearly no other was; else None."""
    n = len(aside)
    if n < 2 * least:
        return None
    before = np.concatenate([[0], np.cumsum(aside)])
    breaks = np.arange(least, n - least + 1)
    # The poses at odds with a run from there on.
    late = before[breaks] + (n - breaks) - (before[n] - before[breaks])
    early = n - late
    k = int(breaks[np.argmin(late)] if late.min() <= early.min() else breaks[np.argmin(early)])
    run, rest = (slice(k, n), slice(0, k)) if late.min() <= early.min() else (slice(0, k), slice(k, n))
    if np.mean(~aside[run]) > MOST_WITHIN or np.mean(aside[rest]) > MOST_BESIDE:
        return None
    return run


def _suspicion(dataset: Dataset, aside: Array, moved: Array, session: Array) -> Suspicion | None:
    """Return the suspicion if nearly all of the poses ``moved`` ``(N,)`` agree with the others once their session is another; else None.

    If a boundary of stated sessions lies at one end of them, the session on its other side is tried first: the boundary may stand at the wrong pose.
    """
    rows = np.flatnonzero(moved)
    own = np.flatnonzero(session == session[rows[0]])
    at_end = rows[0] != own[0]
    neighbour, at = (rows[-1] + 1, rows[0]) if at_end else (rows[0] - 1, rows[-1] + 1)
    ids, poses = dataset.pose_ids, f"poses {dataset.pose_ids[rows[0]]} to {dataset.pose_ids[rows[-1]]}"
    if 0 <= neighbour < len(ids) and (
        found := _fit_with(dataset, aside, moved, np.where(moved, session[neighbour], session))
    ):
        n_fitting, rms = found
        boundary, when = (neighbour, "late") if at_end else (rows[0], "early")
        sentence = (
            f"{poses} contradict the others of their session, and {n_fitting} of these {len(rows)} fit the session that "
            f"{'begins' if at_end else 'ends'} at pose {ids[neighbour]} (to {in_mm(rms)} mm in the median): the column session of poses.csv "
            f"probably changes too {when}, at pose {ids[boundary]}; let it change at pose {ids[at]}"
        )
        return Suspicion("session", f"pose {ids[boundary]}", sentence, None, rms)
    if (found := _fit_with(dataset, aside, moved, np.where(moved, session.max() + 1, session))) is None:
        return None
    n_fitting, rms = found
    what = "the planes or the arm's base were" if dataset.planes else "the tracker or the arm's base was"
    remedy = f"write a column session into poses.csv whose value changes at pose {ids[at]}"
    if dataset.session is not None:
        remedy = f"let the column session of poses.csv change at pose {ids[at]} too"
    sentence = (
        f"{poses} contradict the others, and {n_fitting} of these {len(rows)} fit with a session of their own (to {in_mm(rms)} mm in the median): "
        f"{what} probably set up anew before pose {ids[at]}; {remedy}"
    )
    return Suspicion("session", f"pose {ids[at]}", sentence, None, rms)


def _fit_with(dataset: Dataset, aside: Array, moved: Array, session: Array) -> tuple[int, float] | None:
    """Return how many of the poses ``moved`` agree with the others under other sessions ``(N,)``, and the residual [m]; None if too few do."""
    with_it = replace(dataset, poses=dataset.poses.assign(session=session))
    try:
        wrong = np.isin(dataset.pose_ids, clean(with_it).outlier_poses)
    except ScalarError:
        return None
    if wrong[moved].mean() > MOST_BESIDE or wrong.sum() > aside.sum() - (1 - MOST_BESIDE) * moved.sum():
        return None
    fit = full_fit(with_it.subset(~wrong))
    return None if fit is None else (int(np.sum(moved & ~wrong)), fit.rms)
