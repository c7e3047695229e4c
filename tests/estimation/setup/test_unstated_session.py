"""A tracker that was set up anew is found beside single gross errors, and half of the campaign is not taken for such errors."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import clean
from scalar.estimation.setup.sessions.unstated_session import run_set_aside, unstated_session
from scalar.geometry.se3 import exp_so3
from tests.random_scene import make_scene

MOVED_AT = 45  # row from which on the tracker stands elsewhere
WRONG = [7, 20, 60]  # rows with a gross error


@pytest.fixture(scope="module")
def moved():
    """Return seventy-five poses, three of them with a gross error, before a tracker that was set up anew without a column ``session``."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = dataset.points.copy()
    points[MOVED_AT:] = points[MOVED_AT:] @ exp_so3([0.0, 0.4, -0.6]).T + [0.3, 0.0, 0.2]
    points[WRONG] += 0.2
    return replace(dataset, points=points)


def test_the_refusal_names_the_missing_session_once_and_the_gross_errors(moved):
    """Thirty poses of another set-up have one message, and nobody is told to remove them."""
    ids = moved.pose_ids
    with pytest.raises(InvalidInput) as refused:
        calibrate(moved)
    first, *others = map(str, refused.value.faults)
    assert f"poses {ids[MOVED_AT]} to {ids[-1]}" in first and "29 of these 30 fit" in first
    assert f"value changes at pose {ids[MOVED_AT]}" in first
    assert not [
        said for said in others if any(f"pose {number} contradicts" in said for number in ids[MOVED_AT:])
    ]


def test_gross_errors_that_fit_no_set_up_of_their_own_are_no_session(moved):
    """Fifteen wrong poses at the end stay gross errors; so do poses that do not follow each other."""
    points = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset.points.copy()
    points[-15:] += 0.1 * np.random.default_rng(3).normal(size=(15, 3))
    ids = moved.pose_ids
    assert unstated_session(replace(moved, points=points), ids[-15:].tolist()) is None
    session = np.where(np.arange(len(ids)) < len(ids) - 15, "a", "b")
    stated = replace(moved, points=points, poses=moved.poses.assign(session=session))
    with pytest.raises(Undetermined, match="no pose of session b agrees"):
        clean(stated)
    assert unstated_session(moved, ids[::3].tolist()) is None
    assert unstated_session(moved, ids[:5].tolist()) is None


BEGIN, END = 30, 42  # rows of stated session b that belong elsewhere


def with_sessions(own_place, late=False):
    """Return two stated sessions, b from row ``BEGIN`` on (or ``END``, if late), whose set-up changed at row ``END`` (``BEGIN``).

    The poses between belong to the session on the other side of the boundary, or were measured from a place of their own.
    """
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = dataset.points.copy()

    def move(rows, share):
        points[rows] = points[rows] @ exp_so3([0.0, 0.4 * share, -0.6 * share]).T + [0.3 * share, 0.0, 0.2]

    move(slice(BEGIN if late else END, None), 1.0)
    if own_place:
        move(slice(BEGIN, END), 2.0)
    session = np.where(np.arange(len(points)) < (END if late else BEGIN), "a", "b")
    return replace(dataset, points=points, poses=dataset.poses.assign(session=session))


@pytest.mark.parametrize("late", [False, True])
def test_a_boundary_at_the_wrong_pose_is_to_be_moved(late):
    """Poses beside a stated boundary that fit the other session need no third one."""
    dataset = with_sessions(own_place=False, late=late)
    ids = dataset.pose_ids
    found = unstated_session(dataset, ids[BEGIN:END].tolist())
    assert found is not None
    sentence, stated, true = found[0].sentence, *((END, BEGIN) if late else (BEGIN, END))
    assert f"changes too {'late' if late else 'early'}, at pose {ids[stated]};" in sentence
    assert sentence.endswith(f"let it change at pose {ids[true]}")


@pytest.mark.parametrize("late", [False, True])
def test_a_third_session_begins_or_ends_within_a_stated_one(late):
    """The pose at which the column has to change as well is the one at which it does not change yet."""
    dataset = with_sessions(own_place=True, late=late)
    ids = dataset.pose_ids
    found = unstated_session(dataset, ids[BEGIN:END].tolist())
    assert found is not None
    assert found[0].sentence.endswith(f"change at pose {ids[BEGIN if late else END]} too")


def test_a_reflector_that_was_moved_is_said_though_no_session_explains_it():
    """Poses at the end that follow each other and were set aside are said to be one change; scattered ones are not."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    ids = dataset.pose_ids
    found = run_set_aside(dataset, ids[-20:].tolist())
    assert found is not None and found.where == f"pose {ids[-20]}"
    assert f"from {ids[-20]} to {ids[-1]}" in found.sentence and "on the flange" in found.sentence
    first = run_set_aside(dataset, ids[:20].tolist())
    assert first is not None and first.where == f"pose {ids[20]}"
    assert run_set_aside(dataset, ids[::3].tolist()) is None
