"""Noise blocks for a config, and tests of the errors in a simulated scene."""

import numpy as np
from scipy import stats

ALPHA = 1e-6  # a true statement about chance fails once in a million seeds; ours are fixed beforehand


def noise(**changes):
    """Return a complete `noise` block with everything off but `changes`."""
    off = ("range_noise_std_m", "scan_bias_std_m", "joint_noise_std_rad", "range_quantum_m")
    return dict.fromkeys(off, 0.0) | changes


def ranges_of(scene):
    """Return the measured ranges (N, M) [m] along the rays."""
    return np.linalg.norm(scene.points, axis=2)


def assert_standard_normal(z):
    """Assert that z are independent draws of a standard normal, as far as `ALPHA` lets one doubt it."""
    z = np.ravel(z)
    assert stats.kstest(z, "norm").pvalue > ALPHA
    assert 2 * min(stats.chi2.cdf(z @ z, z.size), stats.chi2.sf(z @ z, z.size)) > ALPHA
    assert abs(z[1:] @ z[:-1]) / np.sqrt(z.size) < stats.norm.isf(ALPHA)
