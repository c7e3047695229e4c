"""The time constant of a warm-up is fitted: right to its standard error, from any start of the search."""

import json

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.effects.saving import effect_from_mapping, effect_to_mapping
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import A, D, Flaws, PoseData, make_cell

GROWTH, CONSTANT = 5e-4, 350.0  # m/m, s


def clock(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return a time of half an hour in all."""
    return {"time": np.cumsum(rng.uniform(5.0, 15.0, n_poses))}


def warming_up(seed: int):
    """Return a dataset of an arm that warms up while it works."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: PoseData) -> np.ndarray:
        return GROWTH * (1 - np.exp(-at.columns["time"] / CONSTANT))[:, None, None] * lengths

    return make_cell(
        Flaws(geometry=growth), seed=seed, poses_per_plane=60, points_per_scan=20, columns=clock
    ).dataset


@pytest.fixture(scope="module")
def fits():
    """Return the warm-ups fitted to six datasets, each from a time constant that is too small and from one that is too large."""
    found = []
    for seed in range(310, 316):
        dataset = warming_up(seed)
        model, prepared = geometry_fit(dataset)
        for start in (100.0, 1000.0):
            state = refit(dataset, model, prepared.free, [ThermalDrift("time", 0.0, start)])
            errors = np.linalg.inv(gram(state))
            std = np.sqrt(np.diag(errors))[-2:]
            found.append((seed, state.effects[0], std))
    return found


def gram(state):
    """Return the normal equations of all free parameters, the warm-up's two coefficients last."""
    J = state.linearised()[1]
    return J.T @ J


def test_the_constant_is_found_to_its_standard_error(fits):
    """Over the datasets, growth and time constant are off by about one standard error, and never by four."""
    z = []
    for _, effect, std in fits:
        stated = effect.stated(list(std))
        z += [
            (stated["growth_m_per_m"][0] - GROWTH) / stated["growth_m_per_m"][1],
            (stated["time_constant_s"][0] - CONSTANT) / stated["time_constant_s"][1],
        ]
    assert np.max(np.abs(z)) < 4.0 and 0.4 < np.sqrt(np.mean(np.square(z))) < 1.8, z


def test_the_start_does_not_matter(fits):
    """From both starts the same time constant is found, to a hundredth of its standard error."""
    for (_, low, std), (_, high, _) in zip(fits[::2], fits[1::2], strict=True):
        (a, error), (b, _) = (effect.stated(list(std))["time_constant_s"] for effect in (low, high))
        assert abs(a - b) < 0.01 * error


def test_the_time_constant_is_saved(fits):
    """A file contains the time constant that was fitted, to the last bit."""
    for _, effect, std in fits:
        back = effect_from_mapping(json.loads(json.dumps(effect_to_mapping(effect, list(std)))))
        assert back.stated(list(std)) == effect.stated(list(std))
