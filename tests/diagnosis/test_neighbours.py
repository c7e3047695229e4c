"""Whether neighbours are alike: uniform chances where they are not, and tiny ones where something acts on them."""

import numpy as np
import pytest

from scalar.diagnosis.neighbours import alike


def chances(course, seeds=400, n=150):
    """Return the chances over many seeds, of draws that are added to a course of the order."""
    found = []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, 5])
        order, groups = rng.permutation(n).astype(float), rng.integers(0, 3, n)
        z = rng.standard_normal((n, 3)) * rng.uniform(0.5, 2.0, (n, 1)) + course(order / n)[:, None]
        found.append(alike(z, groups, order))
    return np.array(found)


def test_where_the_order_means_nothing_the_chance_is_what_it_says():
    """Of draws with unlike spreads, a share p has a chance below p, up to what 400 draws can show."""
    found = chances(lambda x: np.zeros_like(x))
    for p in (0.5, 0.1, 0.02):
        share = np.mean(found < p)
        assert abs(share - p) < 4 * np.sqrt(p * (1 - p) / len(found)) + 0.25 * p
    assert found.min() > 1e-6


@pytest.mark.parametrize("course", [lambda x: np.sin(15 * x), lambda x: np.where(x > 0.6, 1.5, 0.0)])
def test_a_course_of_the_size_of_the_noise_is_seen(course):
    """In at least 95 of 100."""
    assert np.mean(chances(course, seeds=100) < 1e-4) >= 0.95


def test_few_poses_say_nothing():
    """With fewer poses a plate than neighbours need, the chance is one."""
    z = np.ones((9, 3))
    assert alike(z, np.arange(9) // 3, np.arange(9.0)) == 1.0
