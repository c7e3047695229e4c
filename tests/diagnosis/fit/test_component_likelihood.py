"""The likelihood of two variances, one of rank one, against dense covariances; and their estimates over many draws."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from scalar.data.moves import move_columns, moves_in_order, speeds
from scalar.diagnosis.fit.component_likelihood import Spectrum, of_one, of_two
from tests.turning import turning

DRAWS = 60
N, M, K = 150, 4, 3


def drawn(seed, v, w):
    """Return rows ``(N, M)`` of the covariance ``I + v D D' + w u u'``, with D D' and u; D differs from pose to pose."""
    rng = np.random.default_rng(seed)
    D, u = rng.normal(size=(N, M, K)) * rng.uniform(0.3, 3.0, (N, 1, 1)), rng.normal(size=(N, M))
    kernel = D @ np.swapaxes(D, 1, 2)
    covariance = np.eye(M) + v * kernel + w * u[:, :, None] * u[:, None, :]
    rows = np.stack([rng.multivariate_normal(np.zeros(M), C) for C in covariance])
    return rows, kernel, u


def log_likelihood(rows, kernel, u, v, w):
    """Return the log likelihood by dense covariances [nats]."""
    covariance = np.eye(M) + v * kernel + w * u[:, :, None] * u[:, None, :]
    return sum(multivariate_normal.logpdf(r, np.zeros(M), C) for r, C in zip(rows, covariance, strict=True))


def test_the_gain_is_that_of_dense_covariances_and_no_neighbour_has_more():
    """At the variances found, the gain is the difference of two dense log likelihoods, and changing either by a tenth lowers it."""
    rows, kernel, u = drawn(0, 0.5, 2.0)
    found = of_two(rows, Spectrum.of(kernel), u)
    at_zero = log_likelihood(rows, kernel, u, 0.0, 0.0)
    best = log_likelihood(rows, kernel, u, *found.variances)
    assert found.gain == pytest.approx(best - at_zero, abs=1e-6)
    for factors in ((1.1, 1.0), (0.9, 1.0), (1.0, 1.1), (1.0, 0.9)):
        assert log_likelihood(rows, kernel, u, *found.variances * factors) < best


def test_two_variances_are_estimated_without_bias_and_scatter_as_stated():
    """Over 60 draws the errors over their standard errors have a mean near zero and a standard deviation near one."""
    truth = np.array([0.5, 2.0])
    pulls = []
    for seed in range(DRAWS):
        rows, kernel, u = drawn(seed, *truth)
        found = of_two(rows, Spectrum.of(kernel), u)
        pulls.append((found.variances - truth) / np.sqrt(np.diag(found.covariance)))
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 4 / np.sqrt(DRAWS))
    assert np.all((np.std(pulls, axis=0) > 0.7) & (np.std(pulls, axis=0) < 1.4))


def test_without_the_second_error_its_gain_is_that_of_chance():
    """Twice the gain over one variance is at most chi-squared with one degree of freedom: above 3.84 in few of 60 draws."""
    gains = []
    for seed in range(DRAWS):
        rows, kernel, u = drawn(seed, 0.5, 0.0)
        spectrum = Spectrum.of(kernel)
        gains.append(of_two(rows, spectrum, u).gain - of_one(rows, spectrum)[0])
    assert min(gains) > -1e-3
    assert np.sum(2 * np.array(gains) > 3.84) <= 6


def test_speeds_are_shares_of_the_fastest_joint_of_a_kind():
    """A turning joint is compared with the turning joints, a slide with slides; at rest and where the step is not known, all are zero."""
    q = np.array([[0.0, 0.0, 0.0], [0.5, -1.0, 0.2], [0.5, -1.0, 0.2], [0.4, -1.0, 0.1]])
    columns = moves_in_order(q, np.arange(4.0), turning(q.shape[1]))
    assert set(columns) == set(move_columns(3))
    expected = [[0.0, 0.0, 0.0], [0.5, -1.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, -1.0]]
    np.testing.assert_allclose(speeds(columns, [False, False, True], 4), expected)
    np.testing.assert_array_equal(speeds({}, [False, False, True], 4), np.zeros((4, 3)))
