"""Names that lmfit can take: valid, unique, in the same order, and values that come back."""

import keyword

import lmfit
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scalar.estimation.lmfit_parameters import from_lmfit, lmfit_names, to_lmfit


@given(st.lists(st.one_of(st.text(min_size=1, max_size=12), st.sampled_from(keyword.kwlist)), max_size=8))
def test_any_names_become_valid_and_unique(names):
    """Whatever a user calls a plane, lmfit accepts the converted name, and no two names become one."""
    safe = lmfit_names(names)
    assert len(set(safe)) == len(names)
    for name in safe:
        assert lmfit.parameter.valid_symbol_name(name)


def test_names_that_are_valid_stay():
    """Names of parameters that lmfit accepts are not changed."""
    names = ["a_2", "alpha_2", "beta_3", "sensor_x", "normal_floor_u", "distance_floor"]
    assert lmfit_names(names) == names


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=6))
def test_values_come_back(values):
    """Values that are given to lmfit and taken back are the same, in the same order."""
    parameters = lmfit.Parameters()
    for parameter in to_lmfit([f"p_{i}" for i in range(len(values))], np.array(values)):
        parameters[parameter.name] = parameter
    assert from_lmfit(parameters).tolist() == values


def test_parameters_are_those_of_the_constructor_and_share_nothing():
    """All that lmfit's constructor sets is set, apart from the function without state by which a value without bounds is passed on."""
    both = to_lmfit(["a_1", "a_2"], np.array([0.25, -3.0]))
    for own, theirs in zip(both, (lmfit.Parameter("a_1", 0.25), lmfit.Parameter("a_2", -3.0)), strict=True):
        kept, expected = dict(vars(own)), dict(vars(theirs))
        assert kept.pop("from_internal")(1.5) == expected.pop("from_internal")(1.5) == 1.5
        assert kept == expected
    lists = [[id(kept) for kept in vars(own).values() if isinstance(kept, list | dict)] for own in both]
    assert not set(lists[0]) & set(lists[1])
