"""Poses that follow one path are told from those that come back."""

import numpy as np
import pytest

from scalar.data.path import follow_one_path

COUNT, JOINTS = 150, 6


def path(rng: np.random.Generator) -> np.ndarray:
    """Return joint angles ``(N, n)`` [rad] along a smooth path, each joint by half a turn at most."""
    s = np.linspace(0.0, 1.0, COUNT)
    return np.stack([np.sin(rng.uniform(1.5, 3.0) * s + rng.uniform(0, 6)) for _ in range(JOINTS)], axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_a_path_that_never_comes_back_is_one(seed):
    """So is the same path with three readings of each pose, with a joint that stands still, and measured in the other direction."""
    rng = np.random.default_rng(seed)
    q = path(rng)
    assert follow_one_path(q)
    assert follow_one_path(q[::-1])
    assert follow_one_path(np.repeat(q, 3, axis=0) + rng.normal(0, 1e-5, (3 * COUNT, JOINTS)))
    assert follow_one_path(np.column_stack([q, np.full(COUNT, 0.3)]))


@pytest.mark.parametrize("seed", range(5))
def test_poses_in_random_order_and_returns_are_none(seed):
    """Random poses are no path, even if each is read three times; neither is a path that is measured twice, or whose poses are mixed."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (COUNT, JOINTS))
    assert not follow_one_path(q)
    assert not follow_one_path(np.repeat(q, 3, axis=0))
    on_path = path(rng)
    assert not follow_one_path(np.vstack([on_path, on_path]))
    assert not follow_one_path(rng.permutation(on_path))


def test_an_arm_that_goes_home_between_poses_comes_back():
    """Every second pose is the same one, whatever lies between."""
    q = path(np.random.default_rng(7))
    q[::2] = 0.0
    assert not follow_one_path(q)


def test_few_poses_and_poses_that_never_change_are_none():
    """Nothing is known of them."""
    assert not follow_one_path(np.zeros((0, 6)))
    assert not follow_one_path(np.zeros((100, 6)))
    assert not follow_one_path(np.linspace([0.0] * 6, [1.0] * 6, 10))
