"""Joints that never move are named, and data in which nothing moves are a fault."""

import numpy as np
import pytest

from scalar.data.motion import (
    at_few_positions,
    faults_without_motion,
    positions,
    still_in_words,
    still_joints,
)


@pytest.mark.parametrize("still", [[], [2], [1, 3], [1, 2, 3]])
def test_the_joints_that_never_move_are_named(still: list[int]) -> None:
    """A joint counts as still if its position scatters by no more than an encoder does, whatever the position is."""
    rng = np.random.default_rng(1)
    q = rng.uniform(-2.0, 2.0, (20, 3))
    for joint in still:
        q[:, joint - 1] = 1.2 + rng.uniform(-1e-5, 1e-5, 20)
    assert still_joints(q) == still
    assert all(str(joint) in still_in_words(still) for joint in still)
    assert bool(still_in_words(still)) == bool(still)


def test_one_or_two_poses_show_no_stillness() -> None:
    """Of one pose nothing can be said; it is refused because it is one."""
    assert still_joints(np.zeros((1, 6))) == still_joints(np.zeros((2, 6))) == []


@pytest.mark.parametrize("targets", [1, 2])
def test_poses_or_points_that_are_all_the_same_are_a_fault_of_their_table(targets: int) -> None:
    """Several targets stand in several places; their points are all the same if each target's are."""
    rng = np.random.default_rng(2)
    q, items = rng.uniform(-2.0, 2.0, (20, 6)), np.tile(np.arange(targets), 20)
    places = rng.uniform(-1.0, 1.0, (targets, 3))
    fixed, moving = places[items], rng.uniform(-1.0, 1.0, (20 * targets, 3))
    assert not faults_without_motion(q, moving, items, "points.csv")
    for angles, points, files in (
        (q, fixed, ["points.csv"]),
        (0.0 * q, moving, ["poses.csv"]),
        (0.0 * q, fixed, ["poses.csv", "points.csv"]),
    ):
        assert [fault.file for fault in faults_without_motion(angles, points, items, "points.csv")] == files


def test_a_sensor_without_a_table_of_points_has_none_that_are_the_same() -> None:
    """The touch probe's point is its own origin, which no table has."""
    assert not faults_without_motion(np.eye(6), np.empty((0, 2)), np.empty(0), "points.csv")


def test_positions_that_differ_by_the_jitter_of_a_record_are_one():
    """They are numbered in ascending order."""
    q = np.array([0.5, -1.0, 0.5001, 2.0, -0.9999])
    assert positions(q).tolist() == [1, 0, 1, 2, 0]
    assert positions(q[:0]).tolist() == []


def test_joints_of_a_grid_stand_at_few_positions():
    """A joint that stands still, one at two positions and one that stands elsewhere in each pose do not; one with five steps does."""
    n = 40
    q = np.column_stack([np.zeros(n), np.arange(n) % 2, 0.3 * (np.arange(n) % 5), np.linspace(-2, 2, n)])
    assert at_few_positions(q) == [3]
    assert at_few_positions(q[:0]) == []


@pytest.mark.parametrize("n", [60, 1000, 12_000])
def test_random_positions_are_never_few_however_close_they_lie(n):
    """Over a range of half a radian, many poses have neighbours on both sides, and form a few groups that are no positions."""
    q = np.random.default_rng(n).uniform(0.0, 0.5, (n, 20))
    assert at_few_positions(q) == []
