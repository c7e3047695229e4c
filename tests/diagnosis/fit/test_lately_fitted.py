"""A state that was fitted lately is asked for again, not fitted again; the optimum of other effects, or one that depends on the start, is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.lately_fitted import MOST_STATES
from scalar.effects.command_line import parse_effects
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.model import ParameterPrior
from tests.diagnosis.cases import scale


@pytest.fixture(scope="module")
def without_effects():
    """Return a function that returns the state of a dataset without effects, on new rows, and one that reads effects."""
    dataset = scale(1, poses_per_plane=20)[0].dataset
    model, prepared = geometry_fit(dataset)

    def state():
        return refit(dataset, model, prepared.free, ())

    return state, lambda words: parse_effects(words, dataset)


def test_the_same_effects_are_fitted_once(without_effects):
    """From another model the same state comes back, and it is the optimum that a fit from there finds."""
    state, effects = without_effects[0](), without_effects[1]
    first = state.refitted(effects("joint_scale:3,base_compliance"))
    detour = state.refitted(effects("joint_scale:3"))
    again = detour.refitted((*detour.effects, *effects("base_compliance")))
    assert again is first
    fresh = refit(state.dataset, detour.model, state.geometry_free, effects("joint_scale:3,base_compliance"))
    std = np.sqrt(np.diag(np.linalg.inv(fresh.linearised()[1].T @ fresh.linearised()[1])))
    # Sensor and planes are counted from references of their own.
    same = np.r_[fresh.model.blocks["geometry"], fresh.model.blocks["effects"]]
    change, std_of_all = first.model.vector - fresh.model.vector, np.full(len(fresh.free), np.inf)
    std_of_all[fresh.free] = std
    np.testing.assert_array_less(np.abs(change / std_of_all)[same], 1e-5)


@pytest.mark.parametrize(
    "other", ["joint_scale:2", "joint_scale:3,base_compliance", "", "joint_harmonic:3:1"]
)
def test_other_effects_are_fitted(without_effects, other):
    """Another place, another number, or another kind of effects is another optimum."""
    state, effects = without_effects[0](), without_effects[1]
    first = state.refitted(effects("joint_scale:3"))
    found = state.refitted(effects(other))
    assert found is not first
    assert [effect.key for effect in found.effects] == [effect.key for effect in effects(other)]


def test_another_prior_of_the_coefficients_is_another_optimum(without_effects):
    """The same orders with narrower priors are fitted anew, and come out smaller."""
    state, effects = without_effects[0](), without_effects[1]
    (series,) = effects("joint_harmonic:3:1")
    wide, narrow = (state.refitted([series.with_term_std([std])]) for std in (1e-1, 1e-7))
    assert np.abs(narrow.effects[0].coefficients).max() < np.abs(wide.effects[0].coefficients).max()


def test_with_priors_on_parameters_the_start_decides(without_effects):
    """The weight of such priors depends on the start, so that no state is kept."""
    state, effects = without_effects[0](), without_effects[1]("joint_scale:3")
    prior = ParameterPrior("d_2", float(state.model.robot.geometry[2, 1]), 1e-3, "")
    start = replace(state.model, priors=(prior,))
    assert state.refitted(effects, start) is not state.refitted(effects, start)


def test_few_states_are_kept(without_effects):
    """Of more states than are kept, the one that was asked for longest ago is fitted again."""
    state, effects = without_effects[0](), without_effects[1]
    oldest, *others = (
        effects(f"joint_harmonic:{joint}:{order}") for joint in (2, 3) for order in range(1, MOST_STATES)
    )
    first = state.refitted(oldest)
    others = others[: MOST_STATES - 1]
    for each in others:
        state.refitted(each)
    assert state.refitted(oldest) is first
    for each in [*others, effects("base_compliance")]:
        state.refitted(each)
    assert state.refitted(oldest) is not first
