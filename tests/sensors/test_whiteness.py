"""The test of white noise within scans: its false alarms if the noise is white, and its power if it is not."""

import numpy as np
import pytest

from scalar.sensors.within_scan_noise.whiteness import LAGS, whiteness
from tests.sensors.profiles_of_scans import SIGMA, autoregressive, profiles_of, waves, white

SETS = 200


def p_value(noise, rng, **sizes):
    """Return the p-value of one set of scans."""
    profiles = profiles_of(noise, rng, **sizes)
    return whiteness(profiles, profiles.without(profiles.height, 3), profiles.counts >= 12).p_value


@pytest.mark.parametrize("sizes", [{"scans": 12, "points": (12, 20)}, {"scans": 20, "points": 40}])
def test_p_values_are_uniform_where_the_noise_is_white(sizes, rng):
    """Over 200 small white sets the share of p-values below each level is that level, within four standard deviations."""
    p = np.array([p_value(white, rng, **sizes) for _ in range(SETS)])
    for level in (0.01, 0.05, 0.2, 0.5):
        share = np.mean(p < level)
        assert abs(share - level) < 4.0 * np.sqrt(level * (1.0 - level) / SETS), level


def test_moments_are_those_of_white_noise(rng):
    """Correlations divided by their standard errors have mean zero and variance one at every lag, for short scans too."""
    z = []
    for _ in range(SETS):
        profiles = profiles_of(white, rng, scans=12, points=(12, 16))
        found = whiteness(profiles, profiles.without(profiles.height, 3), profiles.counts >= 12)
        z.append(found.correlation / found.band)
    z = np.array(z)
    assert z.shape == (SETS, LAGS)
    assert np.all(np.abs(z.mean(0)) < 4.0 / np.sqrt(SETS))
    assert np.all(np.abs(z.var(0) - 1.0) < 4.0 * np.sqrt(3.0 / SETS))


def test_heavy_tails_are_not_correlation(rng):
    """Independent errors of Student's t with three degrees of freedom are found correlated no more often than the level allows."""
    heavy = lambda rng, angles, along, ranges: SIGMA * rng.standard_t(3, len(angles))  # noqa: E731
    p = np.array([p_value(heavy, rng, scans=20, points=40) for _ in range(100)])
    assert np.mean(p < 0.05) < 0.05 + 4.0 * np.sqrt(0.05 * 0.95 / 100)


@pytest.mark.parametrize("noise", [autoregressive(0.4), autoregressive(-0.4), waves(5e-5, 0.03)])
def test_correlated_noise_is_significant(noise, rng):
    """Positively or negatively correlated neighbours, and waves of the surface, are significant in sixty scans."""
    assert p_value(noise, rng) < 1e-6


def test_a_bow_is_not_correlation(rng):
    """The parabola to which a plane bowed by a millimetre over a metre bends every scan is removed before the test."""
    assert p_value(lambda *scan: white(*scan), rng, scans=30) > 1e-4
    profiles = profiles_of(white, rng, scans=30, bow=1e-3)
    assert whiteness(profiles, profiles.without(profiles.height, 3), profiles.counts >= 12).p_value > 1e-4
