"""The covariance of a scan's rows, and the restricted likelihood of its parameters, agree with dense matrices and with simulation."""

from itertools import combinations

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.stats import multivariate_normal

from scalar.sensors.within_scan_noise.correlation import sample_of
from scalar.sensors.within_scan_noise.correlation_shapes import KERNELS, Kernel, Part
from scalar.sensors.within_scan_noise.restricted_likelihood import ScanSample
from scalar.sensors.within_scan_noise.row_covariance import inverse_factors, quadratic_forms, row_covariance
from tests.sensors.profiles_of_scans import autoregressive, profiles_of, white
from tests.test_kernels import without_library

PITCH = 0.7 / 79  # rad, of eighty points over the fan


def part(kernel, length, share=0.7):
    """Return a component with a kernel, a length and a share alone."""
    return Part(kernel, length, share, 0.0, 0.0, 0.0, ())


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: f"{k.shape}{'_surface' * k.of_surface}")
def test_kernels_are_correlations(kernel, rng):
    """A kernel is one at distance zero, and its matrix over any points of a line is positive semidefinite."""
    assert kernel(np.zeros(1)) == 1.0
    at = np.sort(rng.uniform(0.0, 10.0, 60))
    assert np.linalg.eigvalsh(kernel(at[:, None] - at)).min() > -1e-9


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: f"{k.shape}{'_surface' * k.of_surface}")
@pytest.mark.parametrize("length", [1.5, 6.0, 20.0])
def test_forms_on_a_grid_are_the_dense_ones(kernel, length, rng):
    """Forms that are interpolated on a grid agree with those of the dense matrix to a hundredth of the largest."""
    profiles = profiles_of(white, rng, scans=9, points=(2, 80))
    at = profiles.angle / PITCH / length
    found = quadratic_forms(profiles, at, kernel)
    for i, (a, b) in enumerate(zip(profiles.starts[:-1], profiles.starts[1:], strict=True)):
        Q = profiles.Q[a:b]
        dense = Q.T @ kernel(at[a:b, None] - at[None, a:b]) @ Q
        assert np.abs(found[i] - dense).max() < 0.01 * max(np.abs(dense).max(), 1.0)


def test_rows_have_the_covariance_that_is_computed(rng):
    """Whitened rows of many scans of autoregressive noise have unit covariance within sampling error, and the first row stays a shift."""
    rho = 0.8
    exact = part(Kernel(False, "exponential"), -1.0 / np.log(rho), share=1.0)
    rows, factors = [], None
    for _ in range(40):
        profiles = profiles_of(autoregressive(rho), rng, scans=50)
        factors = inverse_factors(row_covariance(profiles, np.ones(50), [exact], PITCH))
        y = profiles.sum(profiles.Q * profiles.height[:, None])
        rows.append(np.einsum("nij,nj->ni", factors, y))
    assert factors is not None and np.all(
        factors[:, np.triu_indices(3, 1)[0], np.triu_indices(3, 1)[1]] == 0.0
    )
    rows = np.concatenate(rows)
    covariance = rows.T @ rows / len(rows)
    np.testing.assert_allclose(covariance, np.eye(3), atol=5.0 * np.sqrt(2.0 / len(rows)))


def test_scans_of_one_or_two_points_keep_unit_rows(rng):
    """If a scan has no slope or no curvature, the covariance is still invertible, with variance 1 for that row."""
    profiles = profiles_of(white, rng, scans=6, points=(1, 3))
    V = row_covariance(profiles, np.ones(6), [part(KERNELS[0], 3.0)], PITCH)
    factors = inverse_factors(V)
    assert np.all(np.isfinite(factors))
    short = profiles.counts < 3
    assert short.any() and np.all(V[short, 2, 2] == 1.0)


def test_restricted_likelihood_is_that_of_the_contrasts(rng, monkeypatch):
    """Differences of the restricted likelihood equal those of the normal density of contrasts without each scan's line, variance profiled out.

    NumPy's terms are the compiled ones.
    """
    S, m = 3, 9
    surface, y = np.sort(rng.uniform(0, 0.2, (S, m)), axis=1), rng.standard_normal((S, m))
    lines = np.stack([np.ones((S, m)), surface], axis=1)
    sample = ScanSample(np.concatenate([lines, y[:, None]], axis=1), surface * 50, surface)

    def brute_force(correlation):
        contrasts = [null_space(lines[s]) for s in range(S)]
        small = [A.T @ correlation[s] @ A for s, A in enumerate(contrasts)]
        z = [A.T @ y[s] for s, A in enumerate(contrasts)]
        n = sum(len(v) for v in z)
        variance = sum(v @ np.linalg.solve(C, v) for v, C in zip(z, small, strict=True)) / n
        return sum(multivariate_normal(cov=variance * C).logpdf(v) for v, C in zip(z, small, strict=True))

    def dense(pairs):
        C = np.tile(np.eye(m), (S, 1, 1))
        for k, (i, j) in enumerate(combinations(range(m), 2)):
            C[:, i, j] = C[:, j, i] = pairs[:, k]
        return C

    white_noise = sample.correlation([])
    for kernel in KERNELS:
        C = sample.correlation([part(kernel, 0.05 if kernel.of_surface else 2.0)])
        found = sample.log_likelihood(C) - sample.log_likelihood(white_noise)
        assert found == pytest.approx(brute_force(dense(C)) - brute_force(dense(white_noise)), abs=1e-4)
        compiled = sample.factored(C)
        with monkeypatch.context() as patch:
            without_library(patch)
            determinants, squares = sample.factored(C)
        assert compiled[0] == pytest.approx(determinants, abs=1e-6)
        np.testing.assert_allclose(compiled[1], squares, rtol=1e-6)


def test_a_sample_is_no_larger_for_larger_scans(rng):
    """The sample has a bounded number of points and scans, and the points taken from a scan span it."""
    profiles = profiles_of(white, rng, scans=150, points=400)
    sample, pick = sample_of(
        profiles, profiles.about_lines(np.ones(150, bool)), np.ones(150), np.ones(150, bool), PITCH
    )
    assert sample.bordering.shape[0] == len(pick) <= 60 and sample.bordering.shape[2] <= 48
    span = np.ptp(sample.surface, axis=1)
    whole = [
        np.ptp(profiles.along[a:b]) for a, b in zip(profiles.starts[:-1], profiles.starts[1:], strict=True)
    ]
    np.testing.assert_allclose(span, np.array(whole)[pick])


def test_standardised_heights_are_of_unit_variance(rng):
    """White noise about each scan's own parabola has a mean square of one for each degree of freedom."""
    profiles = profiles_of(white, rng, scans=200)
    e = profiles.without(profiles.height, 3)
    mean_square = np.sum(e * e) / np.sum(profiles.counts - 3)
    assert mean_square == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / len(e)))
