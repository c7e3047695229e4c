"""The test for autocorrelation: p-values are uniform for noise, and tiny if something acts on neighbouring poses."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.noise.autocorrelation import (
    components_along,
    neighbour_p_value,
    neighbours_in_order,
    neighbours_in_two,
)
from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.geometry_fit import geometry_fit
from tests.random_scene import make_scene


def p_values(profile, seeds=400, n=150):
    """Return the p-values of many draws of noise, each added to a profile over the order of the poses."""
    found = []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, 5])
        order, groups = rng.permutation(n).astype(float), rng.integers(0, 3, n)
        z = rng.standard_normal((n, 3)) * rng.uniform(0.5, 2.0, (n, 1)) + profile(order / n)[:, None]
        found.append(neighbour_p_value(z, neighbours_in_order(groups, order)))
    return np.array(found)


def test_p_values_are_uniform_for_noise():
    """For noise whose size differs from pose to pose, a share p of the draws has a p-value below p, within what 400 draws can show."""
    found = p_values(lambda x: np.zeros_like(x))
    for p in (0.5, 0.1, 0.02):
        share = np.mean(found < p)
        assert abs(share - p) < 4 * np.sqrt(p * (1 - p) / len(found)) + 0.25 * p
    assert found.min() > 1e-6


@pytest.mark.parametrize("profile", [lambda x: np.sin(15 * x), lambda x: np.where(x > 0.6, 1.5, 0.0)])
def test_a_profile_of_the_size_of_the_noise_is_significant(profile):
    """A profile as large as the noise has a significant p-value in at least 95 of 100 draws, corrected for a dozen orders."""
    assert np.mean(p_values(profile, seeds=100) < DEFAULTS.autocorrelation.alpha_autocorrelation / 12) >= 0.95


def test_too_few_poses_have_a_p_value_of_one():
    """With fewer poses on a target plane than the test of neighbours needs, the p-value is one."""
    z = np.ones((9, 3))
    assert neighbour_p_value(z, neighbours_in_order(np.arange(9) // 3, np.arange(9.0))) == 1.0


def test_neighbours_in_two_variables_are_the_nearest_whatever_their_units():
    """Each pose has the three nearest poses by rank as neighbours, as a brute-force search finds them; the unit of a variable does not matter."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal((40, 2))
    pairs = {tuple(pair) for pair in neighbours_in_two(values)}
    ranks = np.argsort(np.argsort(values, axis=0), axis=0)
    for i in range(40):
        distance = np.sum((ranks - ranks[i]) ** 2, axis=1).astype(float)
        distance[i] = np.inf
        third = np.sort(distance)[2]
        mine = {k for pair in pairs if i in pair for k in pair} - {i}
        assert set(np.flatnonzero(distance < third)) <= mine
    assert pairs == {tuple(pair) for pair in neighbours_in_two(values * [1.0, 1000.0])}


def test_a_turn_that_moves_nothing_is_no_component_of_the_residual():
    """A tracker measures the origin of the sensor's frame, which no turn of this frame moves: rounding alone is left of the derivative."""
    dataset = make_scene(kind="tracker", seed=3, poses_per_plane=8).dataset
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, ())
    z = np.random.default_rng(1).normal(size=(dataset.n_poses, 3))
    joints, growth, shifts, base = 6, 1, 3, 6
    assert components_along(state, z).shape[1] == joints + growth + shifts + base
