"""The test of recorded columns of few values: p-values are uniform for noise, and tiny if something differs between loads, directions or sessions."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from scalar import diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.noise.autocorrelation import autocorrelation_p_values, most_significant
from scalar.diagnosis.noise.recorded_values import columns_of_few_values, differences_between_groups
from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.geometry_fit import geometry_fit
from tests.random_scene import make_scene

LOADS = (0.0, 2.5, 5.0)


def p_values(of_group, seeds=400, n=90):
    """Return the p-values of many draws of noise of uneven size, each with an error of its own in each of three groups of uneven number."""
    found = []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, 8])
        groups = rng.choice(3, n, p=[0.5, 0.3, 0.2])
        noise = rng.standard_normal(n) * rng.uniform(0.5, 2.0, n)
        found += differences_between_groups((noise + np.array(of_group)[groups])[:, None], groups)
    return np.array(found)


@pytest.fixture(scope="module")
def state():
    """Return the fit of an arm with a tracker, with three loads, two sessions and directions of approach recorded."""
    dataset = make_scene(kind="tracker", seed=3, poses_per_plane=20).dataset
    rng = np.random.default_rng(1)
    n = dataset.n_poses
    poses = dataset.poses.assign(
        payload=np.array(LOADS)[np.arange(n) % 3],
        session=np.where(rng.random(n) < 0.5, "before", "after"),
        **{f"approach{j}": rng.choice([-1.0, 1.0], n) for j in range(1, 7)},
    )
    dataset = replace(dataset, poses=poses)
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


def test_p_values_are_uniform_for_noise():
    """For noise whose size differs from pose to pose, a share p of the draws has a p-value below p, within what 400 draws can show."""
    found = p_values([0.0, 0.0, 0.0])
    for p in (0.9, 0.5, 0.1, 0.02):
        assert abs(np.mean(found < p) - p) < 4 * np.sqrt(p * (1 - p) / len(found))
    assert found.min() > 1e-5


def test_an_error_common_to_all_groups_is_no_difference():
    """An error that all poses share, twice the noise, leaves the p-values uniform at most: they compare the groups with one another."""
    found = p_values([2.0, 2.0, 2.0])
    assert np.mean(found < 0.1) < 0.1 + 4 * np.sqrt(0.1 * 0.9 / len(found))


def test_a_difference_of_the_size_of_the_noise_is_significant():
    """Errors of two groups as large as the noise, one up and one down, are significant in at least 90 of 100 draws, corrected for 250 tests."""
    found = p_values([-1.35, 1.35, 0.0], seeds=100)
    assert np.mean(found < DEFAULTS.autocorrelation.alpha_autocorrelation / 250) > 0.9


def test_p_values_are_those_of_all_signs():
    """Of all 2^16 signs of sixteen poses, about the share that the p-value states gives groups that differ at least as much."""
    rng = np.random.default_rng(7)
    groups = np.arange(16) % 2
    sizes = rng.uniform(0.7, 1.5, 16)
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=15)))
    signs = np.column_stack([np.ones(len(signs)), signs])  # the other half of the signs differ as much
    found = np.array(differences_between_groups(sizes[:, None] * signs.T, groups, 8))
    for p in (0.5, 0.1, 0.01, 0.001):
        assert 0.5 * p < np.mean(found <= p) < 1.3 * p


def test_groups_of_few_poses_are_left_out():
    """Values that fewer poses have than needed are not compared, however far they lie; with one group left there is nothing to compare."""
    groups = np.repeat([0, 1, 2], [30, 30, 5])
    components = np.random.default_rng(5).standard_normal((65, 1))
    components[60:] += 50.0
    assert differences_between_groups(components, groups)[0] > 0.01
    assert differences_between_groups(components, np.minimum(groups, 1) + 7 * (groups == 0), 40) == [1.0]


def test_columns_that_divide_the_poses_are_known(state):
    """Loads, sessions and directions of approach are compared by value; a column of many values, and one that divides alike, are not."""
    poses = state.dataset.poses
    more = poses.assign(
        current=np.arange(len(poses)) % 20, tool=(poses["payload"] == 2.5) + 2 * (poses["payload"] == 0)
    )
    found = columns_of_few_values(replace(state.dataset, poses=more), 12)
    assert [*found] == ["session", *(f"approach{j}" for j in range(1, 7)), "payload"]


@pytest.mark.parametrize("name", ["payload", "session", "approach3"])
def test_structure_over_a_recorded_value_is_found(state, name):
    """Residuals of joint 3 that differ between the recorded values of a column by about their own size are found along this column."""
    assert (
        most_significant(autocorrelation_p_values(state, _residual(state, None, 0)), DEFAULTS.autocorrelation)
        == []
    )
    found = autocorrelation_p_values(state, _residual(state, name, 0))
    assert most_significant(found, DEFAULTS.autocorrelation) == [name]


def test_noise_alone_has_no_structure_over_recorded_values(state):
    """Of 40 draws of noise, none is significant at one in a thousand, and at most as many as chance allows have a p-value below 0.3."""
    chances = [
        min(autocorrelation_p_values(state, _residual(state, None, seed)).values()) for seed in range(40)
    ]
    assert min(chances) > DEFAULTS.autocorrelation.alpha_autocorrelation
    assert np.mean(np.array(chances) < 0.3) < 0.3 + 4 * np.sqrt(0.3 * 0.7 / 40)


def test_an_error_that_follows_the_load_is_reported_with_it():
    """An error of joint 5 that is another one with each of three loads is reported as structure over the load."""
    dataset = make_scene(kind="tracker", seed=1, poses_per_plane=30, noise=5e-5).dataset
    load = np.arange(dataset.n_poses) % 3
    poses = dataset.poses.assign(
        q5=dataset.poses["q5"] + 6e-4 * np.array([0.0, 1.0, -0.3])[load], payload=np.array(LOADS)[load]
    )
    (entry,) = diagnose(replace(dataset, poses=poses)).to_mapping()["effects"]
    assert (entry["name"], entry["depends_on"]) == ("unattributed", ["payload"])


def _residual(state, name, seed):
    """Return whitened noise ``(N, 3)``, with errors of joint 3 that differ between the values of a column."""
    z = np.random.default_rng([seed, 4]).standard_normal((state.dataset.n_poses, 3))
    if name is None:
        return z
    jacobian = state.residuals.linearise_measured(state.model)[1][:, state.model.blocks["geometry"]]
    column = jacobian.reshape(*z.shape, -1)[:, :, state.model.robot.joint_columns][:, :, 2]
    _, groups = np.unique(state.dataset.poses[name].to_numpy(), return_inverse=True)
    errors = np.array([1.2, -1.2, 1.2])[groups]
    return z + errors[:, None] * column / np.linalg.norm(column, axis=1, keepdims=True)
