"""The tail of a sum of products over pairs of neighbours, where the sign of each pose is random."""

import itertools

import numpy as np
import pytest

from scalar.diagnosis.noise.sign_flips import upper_tail


def pairs_in_order(n, lags):
    return np.concatenate([np.column_stack([np.arange(lag, n), np.arange(n - lag)]) for lag in lags])


def every_sum(products, near, n):
    """Return the sums for all 2^(n-1) draws of signs; the last sign may be kept, because only products of signs count."""
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=n - 1)))
    signs = np.column_stack([signs, np.ones(len(signs))])
    return (signs[:, near[:, 0]] * signs[:, near[:, 1]]) @ products


@pytest.mark.parametrize("lags", [(1, 3, 5), (1, 2, 3)])
@pytest.mark.parametrize("heavy", [False, True])
def test_the_tail_is_that_of_all_draws_of_signs(lags, heavy):
    """It is at least two thirds of the exact probability and at most four times it, with and without triangles and large residuals."""
    n = 15
    near = pairs_in_order(n, lags)
    for seed in range(4):
        rng = np.random.default_rng([seed, heavy])
        size = rng.standard_t(3, n) if heavy else rng.standard_normal(n)
        products = size[near[:, 0]] * size[near[:, 1]]
        sums = np.sort(every_sum(products, near, n))
        for chance in (0.1, 0.02, 3e-3):
            value = sums[-int(chance * len(sums))]
            exact = np.mean(sums >= value - 1e-12)
            assert exact / 1.5 < _tail_at(products, near, n, value) < 4.0 * exact


def _tail_at(products, near, n, value):
    """Return the tail at a value that some draw of signs has, by giving the products that draw's signs."""
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=n - 1)))
    signs = np.column_stack([signs, np.ones(len(signs))])
    drawn = signs[:, near[:, 0]] * signs[:, near[:, 1]]
    at = int(np.argmin(np.abs(drawn @ products - value)))
    return upper_tail(products * drawn[at], near, n)


def test_a_sum_of_nothing_has_probability_one():
    """If all products are zero, the sum is zero for all signs."""
    near = pairs_in_order(10, (1,))
    assert upper_tail(np.zeros(len(near)), near, 10) == 1.0


def test_a_sum_of_equal_products_is_very_improbable():
    """The observed sum needs nearly all signs to be equal."""
    near = pairs_in_order(300, (1, 3, 5))
    assert upper_tail(np.ones(len(near)), near, 300) < 1e-12
