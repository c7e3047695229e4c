"""The order of a program has every pose once, is never longer than the given order, and is near the shortest of all."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar.planning.free_moves import order_poses
from scalar.planning.program_order import move_lengths, program_order, tour_length


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_every_pose_once_and_never_longer(n, seed):
    """For any number of poses, the order is a permutation, and no longer than the given order."""
    lengths = move_lengths(np.random.default_rng(seed).uniform(-3, 3, (n, 6)))
    tour = program_order(lengths)
    assert sorted(tour) == list(range(n))
    assert tour_length(lengths, tour) <= tour_length(lengths, list(range(n))) + 1e-12


def test_near_the_shortest_of_all():
    """For six poses the order is never more than 10 % longer than the shortest of all orders, and mostly is the shortest."""
    shortest = 0
    for seed in range(15):
        lengths = move_lengths(np.random.default_rng(seed).uniform(-3, 3, (6, 3)))
        best = min(tour_length(lengths, list(p)) for p in permutations(range(6)))
        found = tour_length(lengths, program_order(lengths))
        assert best - 1e-12 <= found <= 1.1 * best
        shortest += found <= best + 1e-9
    assert shortest >= 10


def test_a_move_through_an_obstacle_is_avoided():
    """Around a wall in the plane of two joints with a gap at its end, the order takes the gap if it can, and says where it cannot."""

    def allowed(q):
        return ~((np.abs(q[:, 0]) < 0.2) & (q[:, 1] < 1.0))

    q = np.array([[-1.0, 0.0], [1.0, 0.0], [-1.0, 1.5], [1.0, 1.5], [-1.0, 0.5], [1.0, 0.5]])
    tour, touching = order_poses(q, allowed)
    assert not touching
    assert sorted(tour) == list(range(6))
    tour, touching = order_poses(q[[0, 1]], allowed)
    assert touching == [0]


def test_without_a_test_no_move_is_judged():
    """Without a test for collisions, the order states nothing about them."""
    assert order_poses(np.eye(3), None)[1] == []


@pytest.mark.parametrize("n", [1, 2])
def test_one_or_two_poses(n):
    """One or two poses are returned as they are, or swapped."""
    assert sorted(program_order(np.zeros((n, n)))) == list(range(n))
