"""A state that was fitted lately is asked for again, not fitted again; another start or other effects are another fit."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.lately_fitted import MOST_STATES
from scalar.effects.command_line import parse_effects
from scalar.estimation.geometry_fit import geometry_fit
from tests.diagnosis.cases import scale


@pytest.fixture(scope="module")
def without_effects():
    """Return a function that returns the state of a dataset without effects, on new rows, and one that reads effects."""
    dataset = scale(1, poses_per_plane=20)[0].dataset
    model, prepared = geometry_fit(dataset)

    def state():
        return refit(dataset, model, prepared.free, ())

    return state, lambda words: parse_effects(words, dataset)


def test_the_same_fit_is_made_once(without_effects):
    """From the same model the same state comes back for the same effects, to the last bit that of a new fit."""
    state, effects = without_effects[0](), without_effects[1]
    first = state.refitted(effects("joint_scale:3,base_compliance"))
    assert state.refitted(effects("joint_scale:3,base_compliance")) is first
    fresh = refit(state.dataset, state.model, state.geometry_free, effects("joint_scale:3,base_compliance"))
    np.testing.assert_array_equal(fresh.model.vector, first.model.vector)


def test_another_start_is_another_fit(without_effects):
    """A fit from another model, or from other coefficients, is made anew: where it ends may depend on where it starts."""
    state, effects = without_effects[0](), without_effects[1]
    first = state.refitted(effects("joint_scale:3"))
    assert state.refitted(effects("joint_scale:3"), first.model) is not first
    assert state.refitted(first.effects) is not first


@pytest.mark.parametrize(
    "other", ["joint_scale:2", "joint_scale:3,base_compliance", "", "joint_harmonic:3:1"]
)
def test_other_effects_are_fitted(without_effects, other):
    """Another place, another number, or another kind of effects is another fit."""
    state, effects = without_effects[0](), without_effects[1]
    first = state.refitted(effects("joint_scale:3"))
    found = state.refitted(effects(other))
    assert found is not first
    assert [effect.key for effect in found.effects] == [effect.key for effect in effects(other)]


def test_another_prior_of_the_coefficients_is_another_fit(without_effects):
    """The same orders with narrower priors are fitted anew, and come out smaller."""
    state, effects = without_effects[0](), without_effects[1]
    (series,) = effects("joint_harmonic:3:1")
    wide, narrow = (state.refitted([series.with_term_std([std])]) for std in (1e-1, 1e-7))
    assert np.abs(narrow.effects[0].coefficients).max() < np.abs(wide.effects[0].coefficients).max()


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
