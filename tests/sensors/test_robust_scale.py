"""The robust standard deviation: it is right for normal errors, and bounded for any values of a minority."""

import numpy as np
import pytest

from scalar.sensors.robust_scale import robust_std


@pytest.mark.parametrize("sigma", [1e-4, 3.0])
def test_it_is_the_standard_deviation_of_normal_errors(sigma):
    """For a hundred thousand normal draws the robust scale is their standard deviation, to a percent."""
    draws = sigma * np.random.default_rng(0).standard_normal(100_000)
    assert robust_std(draws) == pytest.approx(sigma, rel=0.01)


@pytest.mark.parametrize("size", [1e2, 1e300, np.inf])
def test_four_wrong_values_of_ten_leave_it_bounded(size):
    """However large the wrong values are, it stays below four times the standard deviation of the others."""
    draws = np.random.default_rng(0).standard_normal(10_000)
    draws[:4_000] = size
    assert robust_std(draws) < 4.0
