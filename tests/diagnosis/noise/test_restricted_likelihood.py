"""Variance components fitted together: the optimum is that of the likelihood by dense matrices, and estimates vary as their standard errors state."""

import numpy as np
import pytest
from scipy.optimize import minimize

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.noise.identified_components import identified_components
from scalar.diagnosis.noise.restricted_likelihood import fit_components
from tests.diagnosis.fit.test_variance_components import SEEDS
from tests.diagnosis.test_noise_within_scans import autoregressive, before, quiet, scanned
from tests.effects.injected import Flaws, make_cell

N, M = 30, 3


def problem(rng, variances, n=N, priors=2):
    """Return a background, the kernels of three components, and the dense rows, columns and rows of priors from which they were made."""
    D = rng.standard_normal((n, M, 2)) * rng.uniform(0.5, 3.0, (n, 1, 1))
    b = np.zeros((n, M, 1))
    b[:, 0] = rng.uniform(1.0, 2.0, (n, 1))
    kernels = [D @ np.swapaxes(D, 1, 2), b @ np.swapaxes(b, 1, 2), np.tile(np.eye(M), (n, 1, 1))]
    V = np.eye(M) + sum(v * K for v, K in zip(variances, kernels, strict=True))
    r = np.einsum("nij,nj->ni", np.linalg.cholesky(V), rng.standard_normal((n, M))).ravel()
    X = rng.standard_normal((n * M, 6))
    below = np.zeros((priors, 6))
    below[np.arange(priors), np.arange(priors)] = 5.0
    rows, columns = np.r_[r, rng.standard_normal(priors)], np.vstack([X, below])
    return Background.of(rows, columns, n, M), kernels, rows, columns


def dense_cost(kernels, rows, columns, n=N):
    """Return minus the restricted log likelihood as a function of the variances, by dense matrices of all rows."""

    def cost(v):
        V = np.eye(len(rows))
        for i in range(n):
            mine = slice(M * i, M * i + M)
            V[mine, mine] += sum(a * K[i] for a, K in zip(v, kernels, strict=True))
        W = np.linalg.inv(V)
        G = columns.T @ W @ columns
        P = W - W @ columns @ np.linalg.solve(G, columns.T @ W)
        return 0.5 * (np.linalg.slogdet(V)[1] + np.linalg.slogdet(G)[1] + rows @ P @ rows)

    return cost


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("variances", [(0.0, 0.0, 0.0), (0.5, 2.0, 0.3), (3.0, 0.0, 0.0)])
def test_the_optimum_is_that_of_the_dense_likelihood(seed, variances):
    """With priors among the rows, no search from any start finds a greater likelihood, and differences of it agree to 1e-5 nats."""
    background, kernels, rows, columns = problem(np.random.default_rng(seed), variances)
    found = fit_components(background, kernels)
    nothing = fit_components(background, []).log_likelihood
    cost = dense_cost(kernels, rows, columns)
    assert np.all(found.variances >= 0.0)
    assert found.log_likelihood - nothing == pytest.approx(
        cost(np.zeros(3)) - cost(found.variances), abs=1e-5
    )
    for start in (0.05, 1.0):
        best = minimize(cost, np.full(3, start), bounds=[(0.0, None)] * 3, method="L-BFGS-B")
        assert found.log_likelihood - nothing > cost(np.zeros(3)) - best.fun - 2e-3


def test_estimates_vary_as_their_standard_errors_state():
    """Over sixty sets, (hat - true) / std has a mean near zero and a standard deviation near one for each of three components."""
    true = np.array([0.6, 1.5, 0.4])
    pulls = []
    for seed in range(60):
        background, kernels, _, _ = problem(np.random.default_rng(seed), true, n=120)
        found = fit_components(background, kernels)
        pulls.append((found.variances - true) / found.std_errors)
    pulls = np.array(pulls)
    assert np.all(np.abs(pulls.mean(0)) < 5.0 / np.sqrt(60))
    assert np.all((0.7 < pulls.std(0)) & (pulls.std(0) < 1.4))


@pytest.mark.parametrize(
    "name, flaws", [("pose_jitter", Flaws(jitter=2e-4)), ("scan_bias", Flaws(bias=2e-4))]
)
def test_what_repeats_badly_is_identified_given_the_sensors_own_noise(name, flaws):
    """In workcells of natural size the injected component is identified first, given both components of the sensor's noise."""
    for seed in range(SEEDS // 4):
        found = identified_components(before(make_cell(flaws, seed=seed).dataset))
        assert found and found[0].name == name and found[0].p_value < 1e-6


def test_an_arm_with_the_best_repeatability_has_no_finding():
    """With a very precise scanner, joints that repeat to ten microradians show a significant component, and it is no finding."""
    state = before(make_cell(Flaws(jitter=1e-5), seed=2, noise=1e-5, points_per_scan=60).dataset)
    assert state.variance_components and state.variance_components[0].name == "pose_jitter"
    assert not identified_components(state)


def test_noise_that_is_stated_too_small_is_no_jitter():
    """Correlated noise of the points that is not modelled looks like a scatter of whole poses; the components of the sensor's noise explain most of
    it.
    """
    gains = []
    for seed in range(3):
        state = before(scanned(quiet(seed=seed), autoregressive), noise=False)
        assert state.variance_components
        left = identified_components(state)
        gains.append(
            sum(c.log_likelihood_gain for c in left[:1]) / state.variance_components[0].log_likelihood_gain
        )
    assert np.mean(gains) < 0.1
