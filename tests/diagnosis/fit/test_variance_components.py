"""Variance components: random errors of the joints in each pose and of each scan, estimated and distinguished."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.variance_components import columns_by_place, whitening_for
from scalar.estimation.geometry_fit import geometry_fit
from tests.diagnosis.tracked_arm import fitted_arm
from tests.effects.injected import Flaws, make_cell

SEEDS = 16
NOISES = {"pose_jitter": (Flaws(jitter=2e-4), 2e-4), "scan_bias": (Flaws(bias=2e-4), 2e-4)}


def found_in(flaws, seed, **settings):
    dataset = make_cell(flaws, seed=seed, **settings).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ()).variance_components


@pytest.mark.parametrize("name", NOISES)
def test_noise_is_named_and_measured(name):
    """Over 16 workcells the right one of jitter and bias is the likeliest each time, and its standard deviation agrees with the true one as its
    standard error states: (hat - true) / std has a mean near zero and a standard deviation near one.
    """
    flaws, truth = NOISES[name]
    pulls = []
    for seed in range(SEEDS):
        found = found_in(flaws, seed)
        assert found and found[0].name == name, f"seed {seed}"
        pulls.append((found[0].std - truth) / found[0].std_error)
        assert found[0].p_value < 1e-6
    assert abs(np.mean(pulls)) < 4 / np.sqrt(SEEDS)
    assert 0.5 < np.std(pulls) < 1.8


def test_clean_data_have_no_noise_effect():
    """Over 16 workcells, no component is found if scans differ by the noise of their points alone."""
    assert not any(found_in(Flaws(), seed) for seed in range(SEEDS))


def test_whitening_undoes_the_covariance():
    """The inverse square roots turn each pose's covariance into the identity."""
    spread = found_in(Flaws(jitter=2e-4), 3)[0]
    W = whitening_for(spread)
    one = W @ spread.covariance @ np.swapaxes(W, 1, 2)
    np.testing.assert_allclose(one, np.broadcast_to(np.eye(one.shape[1]), one.shape), atol=1e-9)


def test_the_estimate_grows_with_the_noise():
    """The estimate grows with what is injected, down to the size at which it is no longer significant."""
    sizes = [found_in(Flaws(jitter=size), 5)[0].std for size in (1e-4, 2e-4, 4e-4)]
    assert sizes[0] < sizes[1] < sizes[2]


def test_rounding_errors_make_no_place(monkeypatch):
    """A turn of a reflector about its own centre moves nothing: it is no place that may err, whatever rounding errors its derivatives have."""
    state = fitted_arm()
    residual, jacobian = state.residuals.linearise_measured(state.model)
    places = [place for place, _ in columns_by_place(state.residuals, state.model)]
    rounding = 1e-15 * np.abs(jacobian).max() * np.random.default_rng(0).standard_normal(jacobian.shape)
    monkeypatch.setattr(state.residuals, "linearise_measured", lambda model: (residual, jacobian + rounding))
    assert [place for place, _ in columns_by_place(state.residuals, state.model)] == places
    assert {place for place in places if place.startswith("sensor")} == {"sensor.0", "sensor.1", "sensor.2"}
